"""Our engines and MJX as contenders: each takes steps for all walkers and counts them."""

import functools
from collections.abc import Callable, Collection
from typing import Any

import jax
import numpy as np

from mjxwalk.bench import c_contenders
from mjxwalk.bench.bodies import Body, PointBody
from mjxwalk.bench.contact_bodies import ContactBody
from mjxwalk.bench.mjx_step import mjx_workload
from mjxwalk.bench.workload import Workload, fixed_steps
from mjxwalk.engines import lanes, lanes_xla, mjx

LINEAR = "lanes_linear"  # lanes with the linear policy in place of the network


class Engine:
    """`vmap` of one of our engines over walkers that take a fixed number of steps.

    Attributes:
      mapped: the engine's function of all walkers.
      walked: the walkers of the latest call.
    """

    def __init__(self, vmap: Callable[..., Any], workload: Workload) -> None:
        walker = functools.partial(fixed_steps, workload.start, workload.advance)
        self.mapped = vmap(walker, (*workload.axes, None))
        self.walked: Any = None
        self._workload = workload

    def __call__(self, steps_per_walker: int) -> int:
        """Takes steps of control and returns how many of the physics all walkers took together."""
        given = self._workload
        walked = self.mapped(given.genotypes, given.given, np.int32(steps_per_walker))
        self.walked = jax.block_until_ready(walked)
        return given.substeps * int(np.asarray(walked.steps).sum(dtype=np.int64))


class Trials:
    """An engine whose walkers walk whole trials, from the same start each time.

    Attributes:
      engine: that walks.
    """

    def __init__(self, engine: Engine, length: int) -> None:
        self.engine = engine
        self._length = length

    def __call__(self, times: int) -> int:
        """Walks that many trials and returns how many steps all walkers took together."""
        return sum(self.engine(self._length) for _ in range(times))


def make(
    body: Body, size: int, threads: int, *, xla: bool, without: Collection[str] = ()
) -> dict[str, Any]:
    """Returns the contenders by name.

    Args:
      body: of the walkers.
      size: of the population.
      threads: of C MuJoCo.
      xla: whether lanes-xla is one.
      without: names of contenders to leave out.
    """
    if isinstance(body, PointBody):
        field = _of_points(body, size, threads)
    else:
        field = _of_contacts(body, size, threads)
    left_out = {*without, *([] if xla else ["lanes_xla"])}
    return {name: ready() for name, ready in field.items() if name not in left_out}


def _of_points(body: PointBody, size: int, threads: int) -> dict[str, Callable[[], Any]]:
    load = body.workload(size)
    return {
        "lanes": lambda: Engine(lanes.vmap, load),
        "lanes_xla": lambda: Engine(lanes_xla.vmap, load),
        "mjx": lambda: Engine(mjx.vmap, load),
        **c_contenders.of_points(body, size, threads),
    }


def _of_contacts(body: ContactBody, size: int, threads: int) -> dict[str, Callable[[], Any]]:
    load, length = body.workload(size), body.num_actions
    field: dict[str, Callable[[], Any]] = {
        "lanes": lambda: Trials(Engine(lanes.vmap, load), length),
        "lanes_xla": lambda: Trials(Engine(lanes_xla.vmap, load), length),
        "mjx": lambda: Engine(mjx.vmap, mjx_workload(body, size)),
        **c_contenders.of_contacts(body, threads),
    }
    if body.hidden:
        linear = body.linear.workload(size)
        field[LINEAR] = lambda: Trials(Engine(lanes.vmap, linear), length)
    return field
