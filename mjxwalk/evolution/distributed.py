"""Several processes that evolve one run: each evaluates a part of the population.

All of them ask and tell the same, since a strategy is a pure function of its keys; what is gathered
is what the walkers did. The first process alone writes the run.
"""

import hashlib
from typing import Any

import jax
import numpy as np
import numpy.typing as npt

from mjxwalk.errors import first_line
from mjxwalk.evolution.generation import RunState
from mjxwalk.evolution.processes import Processes
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.rollout import Outcome
from mjxwalk.runs import RunError, packing
from mjxwalk.runs.trees import flatten, unflatten


def join(
    coordinator: str | None, processes: int | None, process: int | None
) -> "DistributedProcesses":
    """Waits for the other processes of the run, and returns them.

    Args:
      coordinator: address of the first process, HOST:PORT; None where the cluster tells.
      processes: how many there are; None where the cluster tells.
      process: which of them this is, from 0; None where the cluster tells.

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
    return DistributedProcesses()


class DistributedProcesses(Processes):
    """The processes that `join` has found."""

    @property
    def is_first(self) -> bool:
        """Whether this process writes the run."""
        return jax.process_index() == 0

    def check_same(self, settings: Config) -> None:
        """Raises RunError unless all processes were given these settings."""
        digest = hashlib.blake2b(run_config.text(settings), digest_size=16).digest()
        if len(np.unique(_gather(np.frombuffer(digest, np.uint8)), axis=0)) > 1:
            raise RunError(
                "the processes of this run were given different settings; give all the same"
            )

    def share(self, evaluator: Any) -> "SharedEvaluator":
        """Returns an evaluator of which this process does a part."""
        return SharedEvaluator(evaluator)

    def first_of(self, state: RunState) -> RunState:
        """Returns the state that the first process has.

        Raises:
          RunError: another process has ended.
        """
        content, entries = packing.pack(flatten(state))
        return unflatten(state, packing.unpack(_gather(content)[0].tobytes(), entries))

    def any_of(self, asked: bool) -> bool:
        """Returns whether any process is asked to stop, in all of them alike.

        Raises:
          RunError: another process has ended.
        """
        return bool(_gather(np.array([asked], np.uint8)).any())


class SharedEvaluator:
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
    whole = _gather(part.reshape(-1).view(np.uint8))
    return whole.reshape(-1).view(part.dtype).reshape(-1, *part.shape[1:])


def _gather(content: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
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
