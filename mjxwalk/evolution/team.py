"""Several processes that evolve one run: each evaluates a part of the population.

All of them ask and tell the same, since a strategy is a pure function of its keys; what is gathered
is what the walkers did. The first process alone writes the run.
"""

import contextlib
import hashlib
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt

from mjxwalk.engines.pinning import pinned
from mjxwalk.errors import first_line
from mjxwalk.evolution import champions, loop
from mjxwalk.evolution.evolvable import Evaluator
from mjxwalk.evolution.generation import Evolution, RunState, outer_keys
from mjxwalk.experiments import run_config
from mjxwalk.experiments.goal import Trying
from mjxwalk.experiments.run_config import Config
from mjxwalk.fitting import Fitting
from mjxwalk.rollout import Outcome
from mjxwalk.runs import Interrupted, RunError, packing
from mjxwalk.runs.start import Start
from mjxwalk.runs.trees import flatten, unflatten


def join(coordinator: str | None, processes: int | None, process: int | None) -> None:
    """Waits for the other processes of the run.

    Args:
      coordinator: address of the first process, HOST:PORT; None where the cluster tells.
      processes: how many there are; likewise.
      process: which of them this is, from 0; likewise.

    Raises:
      RunError: they cannot be reached, or nothing tells who they are.
    """
    # It would take SIGTERM for itself, which a run ends by (see `mjxwalk.cli.interrupt`).
    jax.config.update("jax_enable_preemption_service", False)
    try:
        jax.distributed.initialize(coordinator, processes, process)
    except Exception as error:  # JAX passes on those of its network
        raise RunError(
            f"the processes of this run did not find each other ({first_line(error)}); give each "
            "--coordinator HOST:PORT, --processes NUMBER and its own --process NUMBER from 0"
        ) from None


def is_first() -> bool:
    """Returns whether this process writes the run."""
    return jax.process_index() == 0


class Shared:
    """An evaluator of a part of each population; every process ends up with all outcomes.

    Attributes:
      engine: of each process.
      why: the reason for it.
      devices: what all run on, in words.
    """

    def __init__(self, own: Any) -> None:
        self._own = own
        self.engine, self.why = own.engine, own.why
        self.devices = f"{jax.process_count()} processes with {own.devices} each"

    @property
    def compile_s(self) -> float:
        """Seconds that this process spent compiling so far."""
        return self._own.compile_s

    def prepare(self, population: Any, trials: Any, /) -> None:
        """Compiles for a part of arguments of these shapes."""
        size = _share(jax.tree.leaves(population)[0].shape[0])
        part = jax.tree.map(
            lambda leaf: jax.ShapeDtypeStruct((size, *leaf.shape[1:]), leaf.dtype), population
        )
        self._own.prepare(part, trials)

    def evaluate(self, population: Any, trials: Any, /) -> Outcome:
        """Returns the outcomes of all as numpy arrays [pop, trial].

        Raises:
          RunError: another process has ended.
        """
        total = jax.tree.leaves(population)[0].shape[0]
        size = _share(total)
        # Parts of one size: what the last has too few of, it fills up with the last walker.
        places = np.minimum(jax.process_index() * size + np.arange(size), total - 1)
        part = jax.tree.map(lambda leaf: np.asarray(leaf)[places], population)
        own = self._own.evaluate(part, trials)
        return jax.tree.map(lambda leaf: _gathered(leaf)[:total], own)


def _share(total: int) -> int:
    return -(-total // jax.process_count())


def _gathered(part: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Returns the parts of all processes end to end, to the bit."""
    part = np.ascontiguousarray(part)
    whole = gather(part.reshape(-1).view(np.uint8))
    return whole.reshape(-1).view(part.dtype).reshape(-1, *part.shape[1:])


def gather(content: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Returns the bytes of all processes [process, byte].

    Bytes, since JAX would round what has 64 bits.

    Raises:
      RunError: another process has ended.
    """
    from jax.experimental import multihost_utils

    try:
        return np.asarray(multihost_utils.process_allgather(content))
    except Exception as error:  # XLA passes on those of the network
        raise RunError(
            f"another process of this run ended or cannot be reached ({first_line(error)}); what "
            "was finished is saved, and `mjxwalk resume` goes on, on any number of processes"
        ) from None


def check_same(settings: Config) -> None:
    """Returns if all processes were told to evolve the same.

    Raises:
      RunError: they were not.
    """
    digest = hashlib.blake2b(run_config.text(settings), digest_size=16).digest()
    if len(np.unique(gather(np.frombuffer(digest, np.uint8)), axis=0)) > 1:
        raise RunError("the processes of this run were given different settings; give all the same")


def first_of(state: RunState) -> RunState:
    """Returns the state that the first process has."""
    arrays = flatten(state)
    content, entries = packing.pack(arrays)
    return unflatten(state, packing.unpack(gather(content)[0].tobytes(), entries))


def any_of(asked: Callable[[], bool]) -> Callable[[], bool]:
    """Returns what tells whether any process is asked to stop, in all of them alike."""
    return lambda: bool(gather(np.array([asked()], np.uint8)).any())


@pinned()
def follow(
    settings: Config,
    given: Start | None,
    evaluator: Evaluator,
    stopping: Callable[[], bool],
    make_finer: Callable[[], Trying] | None,
) -> None:
    """Works along with the first process to the end of its run, and writes nothing.

    Raises:
      RunError: another process ended.
      Interrupted: the user stopped one of them.
    """
    experiment = settings.experiment
    with contextlib.ExitStack() as stack:
        finer = loop.ahead(settings, make_finer, stack)
        evolution = Evolution(experiment, evaluator, finer)
        state = first_of(evolution.start(settings.seed, given))
        stops = any_of(stopping)
        while not loop.ended(state, settings):
            if stops():
                raise Interrupted(f"stopped after generation {int(state.generation)}")
            state, _ = evolution.advance(state)
        if not isinstance(experiment, Fitting):  # of which the champion is chosen without a trial
            _, key_champion = outer_keys(jax.random.wrap_key_data(jnp.asarray(state.key)))
            champions.choose(experiment, evaluator, state, key_champion)
