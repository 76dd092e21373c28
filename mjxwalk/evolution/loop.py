"""A run from its first generation, or its newest checkpoint, to its champion."""

import contextlib
import time
from collections.abc import Callable
from pathlib import Path
from typing import Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np

from mjxwalk.engines.pinning import pinned
from mjxwalk.evolution import champions
from mjxwalk.evolution.ahead import Ahead
from mjxwalk.evolution.evolvable import Evaluator
from mjxwalk.evolution.generation import Evolution, RunState, outer_keys
from mjxwalk.experiments.goal import Trying
from mjxwalk.experiments.run_config import Config
from mjxwalk.fitting import Fitting
from mjxwalk.runs import Interrupted, Metrics, Result, RunError, folder, metrics, result
from mjxwalk.runs import start as starts
from mjxwalk.runs.checkpoints import Checkpoints, generations, restore_newest
from mjxwalk.runs.trees import flatten, unflatten


@runtime_checkable
class Reporter(Protocol):
    """Shows how a run gets on."""

    def generation(self, line: Metrics, /) -> None:
        """Shows a generation that has been evaluated."""
        ...

    def say(self, text: str, /) -> None:
        """Shows a sentence that the user should know."""
        ...


def never() -> bool:
    """Returns False: nobody asks the run to stop."""
    return False


@pinned()
def evolve(
    path: Path,
    config: Config,
    evaluator: Evaluator,
    reporter: Reporter,
    stopping: Callable[[], bool] = never,
    make_finer: Callable[[], Trying] | None = None,
    share: Callable[[RunState], RunState] | None = None,
) -> Result:
    """Takes a run to its end, from its newest checkpoint that is whole if it has any.

    Ctrl-C is left to raise KeyboardInterrupt, here or, if that got lost in foreign code, by way of
    `stopping`; what was finished before is saved.

    Args:
      path: the run's folder, made and locked by the caller.
      config: the settings in its `config.json`.
      evaluator: of the experiment.
      reporter: is told of each generation.
      stopping: whether to stop before the next generation.
      make_finer: returns what evaluates the experiment at its goal's finer time step.
      share: hands the state to go on from to other processes; None where there are none.

    Raises:
      ValueError: the goal has fine trials, and `make_finer` is not given.
      RunError: a checkpoint could not be saved, or none can be read where there should be one.
      Interrupted: the user stopped it.
    """
    started = time.perf_counter()
    with contextlib.ExitStack() as stack:
        finer = ahead(config, make_finer, stack)
        evolution = Evolution(config.experiment, evaluator, finer)
        state = _begin(path, evolution, config, reporter)
        state = state if share is None else share(state)
        checkpoints = stack.enter_context(
            Checkpoints(path / folder.CHECKPOINTS, keep=config.keep, before=(metrics.FILE,))
        )
        checkpoints.discard_after(int(state.generation))
        try:
            while not ended(state, config):
                if stopping():
                    raise KeyboardInterrupt
                # Waiting for the disk is part of the generation after.
                after, line = evolution.advance(state, since=started)
                started = time.perf_counter()
                _record(path, checkpoints, after, config, line)
                # Not before its line is written: what Ctrl-C saves below must have one.
                state = after
                reporter.generation(line)
                if finer is not None:
                    # Not before the first generation: that compiles itself.
                    finer.start()
                    finer.check()
            checkpoints.wait()
            if not isinstance(config.experiment, Fitting):
                reporter.say("choosing the champion on new terrains")
            return _finish(path, config, evaluator, state)
        except KeyboardInterrupt:
            if int(state.generation) > 0:
                checkpoints.save(int(state.generation), flatten(state))
            checkpoints.wait()
            raise Interrupted(f"stopped after generation {int(state.generation)}") from None


def ahead(
    config: Config, make: Callable[[], Trying] | None, stack: contextlib.ExitStack
) -> Ahead | None:
    """Returns what runs the goal's fine trials, None where there are none."""
    experiment = config.experiment
    goal = experiment.goal
    if not goal.is_fine:
        return None
    if make is None:
        raise ValueError(f"fine_trials is {goal.fine_trials} and make_finer is missing")
    alone = jax.tree.map(lambda leaf: np.asarray(leaf)[None], experiment.template())
    trials = experiment.sample_trials(jax.random.key(0), goal.fine_trials)
    return stack.enter_context(Ahead(make, alone, trials))


def _begin(path: Path, evolution: Evolution, config: Config, reporter: Reporter) -> RunState:
    """Returns the state to go on from, and cuts the figures of generations that are lost."""
    given = None if config.experiment.start == "zero" else starts.read(path)
    start = evolution.start(config.seed, given)
    lines = metrics.read(path)
    checkpoints = path / folder.CHECKPOINTS
    generation, arrays, damaged = restore_newest(checkpoints, up_to=len(lines))
    for reason in damaged.values():
        reporter.say(reason)
    if generation == 0:
        # Killed before its first checkpoint was whole, a run has nothing to lose.
        if damaged or len(lines) > 2 * config.save_every:
            raise RunError(
                f"no checkpoint of {path} can be read, so it cannot be resumed; evolve it again "
                f"with its settings in {path / 'config.json'}"
            )
        if generations(checkpoints):
            raise RunError(
                f"{path / metrics.FILE} ends after generation {len(lines)}, before the oldest "
                "checkpoint: it was cut or changed; put it back as it was, or remove "
                f"{checkpoints} to evolve from generation 1 again"
            )
        metrics.cut(path, 0)
        return start
    which = ", the newest that is whole" if damaged else ""
    reporter.say(f"going on from generation {generation}{which}")
    metrics.cut(path, generation)
    try:
        return unflatten(start, arrays)
    except RunError as error:
        raise RunError(
            f"checkpoint {generation} of {path} is of another experiment: {error}"
        ) from None


def ended(state: RunState, config: Config) -> bool:
    """Returns whether a run has no generation left."""
    if bool(state.reached) or int(state.generation) >= config.experiment.generations:
        return True
    # A strategy that prunes ends by itself.
    return bool(getattr(state.strategy, "finished", False))


def _record(
    path: Path, checkpoints: Checkpoints, state: RunState, config: Config, line: Metrics
) -> None:
    """Adds the generation's line, then starts saving it: a checkpoint never lacks its line."""
    generation = int(state.generation)
    metrics.append(path, line)
    if generation % config.save_every == 0 or ended(state, config):
        checkpoints.save(generation, flatten(state))


def _finish(path: Path, config: Config, evaluator: Evaluator, state: RunState) -> Result:
    key = jax.random.wrap_key_data(jnp.asarray(state.key))
    _, key_champion = outer_keys(key)
    choice = champions.choose(config.experiment, evaluator, state, key_champion)
    lines = metrics.read(path)
    outcome = Result(
        champion=choice.champion,
        generations=len(lines),
        wall_s=sum(line.wall_s for line in lines),
        physics_steps=sum(line.physics_steps for line in lines),
    )
    result.write(path, outcome, flatten(choice.genotype))
    return outcome
