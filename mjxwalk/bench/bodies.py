"""What is simulated: bodies by name, under our contact points or under MuJoCo's contacts."""

import dataclasses
import functools
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax
import numpy as np

from mjxwalk import experiments, robots, rollout
from mjxwalk.bench import contact_bodies
from mjxwalk.bench.contact_bodies import ContactBody
from mjxwalk.bench.workload import Walked, Workload
from mjxwalk.envs import TRIAL_AXES, Trials
from mjxwalk.envs.mjcf import reader
from mjxwalk.experiments import own_body

WEIGHT_SIGMA = 0.3  # ours: as wide as the experiment's first generation


class PointBody(NamedTuple):
    """A body under our contact points, with its experiment's controller.

    Attributes:
      study: makes the experiment.
      peer: makes the same body under MuJoCo's contacts, for C MuJoCo; None to give it the
        experiment's own model, which has none.
    """

    study: Callable[[], Any]
    peer: Callable[[], ContactBody] | None = None

    def workload(self, size: int) -> Workload:
        """Returns walkers with weights drawn at random, all on one terrain."""
        study = self.study()
        draws = np.random.default_rng(0)

        def drawn(leaf: Any) -> Any:
            return draws.normal(0.0, WEIGHT_SIGMA, (size, *leaf.shape)).astype(np.float32)

        return Workload(
            start=functools.partial(rollout.start, study.env, study.controller),
            advance=functools.partial(rollout.advance, study.env, study.controller),
            genotypes=jax.tree.map(drawn, study.template()),
            given=_trials(self).given(np.zeros(size, np.int32)),
            axes=(0, TRIAL_AXES),
        )


Body = PointBody | ContactBody


def _h1_study() -> Any:
    """Returns the experiment of H1 with linear feedback."""
    return own_body.with_body(experiments.get("walk"), reader.read(robots.path("h1")).text)


def _with(make: Callable[[], ContactBody], **changed: Any) -> Callable[[], ContactBody]:
    return lambda: dataclasses.replace(make(), **changed)


_H1 = contact_bodies.shipped("h1")
_WALKER2D = contact_bodies.gymnasium("walker2d_v5.xml")
_HUMANOID = contact_bodies.gymnasium("humanoid.xml")
_GROUND = dataclasses.replace(contact_bodies.FEW_ITERATIONS, self_collision=False)
MAKERS: Mapping[str, Callable[[], Body]] = {  # as `names.BODIES`
    "planar7-points": lambda: PointBody(functools.partial(experiments.get, "planar-lpd")),
    "flame-points": lambda: PointBody(functools.partial(experiments.get, "solomon-3d")),
    "h1-points": lambda: PointBody(_h1_study, _H1),
    "planar7": contact_bodies.shipped("planar7"),
    "flame": contact_bodies.shipped("flame"),
    "walker2d": _WALKER2D,
    "humanoid": _HUMANOID,
    "humanoid-ground": _with(_HUMANOID, law=_GROUND),
    "h1": _H1,
    "walker2d-64x64": _with(_WALKER2D, hidden=(64, 64)),
    "walker2d-256x256": _with(_WALKER2D, hidden=(256, 256)),
}


@functools.cache
def get(name: str, *, file_options: bool = False) -> Body:
    """Returns a body.

    Args:
      name: one of `names.BODIES`.
      file_options: whether MuJoCo's integrator and solver iterations are those of the body's file.

    Raises:
      ValueError: the body comes with a package that is not installed.
    """
    body = MAKERS[name]()
    if not file_options or isinstance(body, PointBody):
        return body
    law = dataclasses.replace(body.law, iterations=None, ls_iterations=None, integrator=None)
    return dataclasses.replace(body, law=law)


@functools.cache
def _trials(body: PointBody) -> Trials:
    """Returns one trial; kept, as in a quick bench making it would be felt each time."""
    return jax.tree.map(np.asarray, body.study().sample_trials(jax.random.key(0), 1))


def num_stopped(walked: Walked) -> int:
    """Returns how many walkers did not take all of their steps, as their physics diverged."""
    state: Any = getattr(walked.walk, "state", walked.walk)
    diverged = ~np.isfinite(np.asarray(state.qpos)).all(axis=1)
    if hasattr(state, "trial"):
        diverged |= np.asarray(state.trial.diverged)
    return int(diverged.sum())
