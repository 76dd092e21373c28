"""A run from its first generation, or its newest checkpoint, to its champion."""

import time
from collections.abc import Callable

import jax
import jax.numpy as jnp

from mjxwalk.engines.pinning import pinned
from mjxwalk.evolution import champions
from mjxwalk.evolution.background_compile import BackgroundCompile
from mjxwalk.evolution.champions import Choice
from mjxwalk.evolution.evolvable import Evaluator
from mjxwalk.evolution.generation import Evolution, is_over, outer_keys
from mjxwalk.evolution.processes import Processes
from mjxwalk.evolution.recorder import Recorder
from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import Interrupted
from mjxwalk.runs.inheritance import Inherited

ALONE = Processes()


def never() -> bool:
    """Returns False: nobody asks the run to stop."""
    return False


@pinned()
def evolve(
    settings: Config,
    evaluator: Evaluator,
    recorder: Recorder,
    *,
    inherited: Inherited | None = None,
    finer: BackgroundCompile | None = None,
    processes: Processes = ALONE,
    stopping: Callable[[], bool] = never,
) -> Choice:
    """Takes a run to its end, from where its recorder left it, and returns its champion.

    Ctrl-C is left to raise KeyboardInterrupt, here or, if that got lost in foreign code, by way of
    `stopping`; what was finished before is saved.

    Args:
      settings: of the run.
      evaluator: of the experiment.
      recorder: keeps the run; of several processes, that of one alone writes it.
      inherited: what the run starts from; None for zero.
      finer: evaluates the experiment at its goal's finer time step; None where it has none.
      processes: that evolve the run together.
      stopping: whether to stop before the next generation.

    Raises:
      ValueError: the goal has fine trials, and `finer` is not given.
      RunError: the run cannot be written or read, or another process ended.
      Interrupted: the user stopped it.
    """
    started = time.perf_counter()
    experiment = settings.experiment
    evolution = Evolution(experiment, evaluator, finer)
    start = evolution.start(settings.seed, inherited)
    state = processes.first_of(recorder.restore(start))
    try:
        while not is_over(state, experiment):
            if processes.any_of(stopping()):
                raise KeyboardInterrupt
            # Waiting for the disk is part of the generation after.
            state, line = evolution.advance(state, since=started)
            started = time.perf_counter()
            recorder.record(state, line)
            if finer is not None:
                # Not before the first generation: that compiles itself.
                finer.start()
                finer.check()
        recorder.complete()
        _, key_champion = outer_keys(jax.random.wrap_key_data(jnp.asarray(state.key)))
        choice = champions.choose(experiment, evaluator, state, key_champion)
        recorder.finish(choice)
        return choice
    except KeyboardInterrupt:
        raise Interrupted(f"stopped after generation {recorder.stop()}") from None
