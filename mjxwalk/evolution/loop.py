"""A run from its first generation, or its newest checkpoint, to its champion."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Protocol, runtime_checkable

import jax
import jax.numpy as jnp

from mjxwalk.evolution import champions
from mjxwalk.evolution.generation import Evaluator, Evolution, RunState, outer_keys
from mjxwalk.runs import Config, Interrupted, Metrics, Result, RunError, folder, metrics, result
from mjxwalk.runs.checkpoints import Checkpoints, restore_newest
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


def evolve(
    path: Path,
    config: Config,
    evaluator: Evaluator,
    reporter: Reporter,
    stopping: Callable[[], bool] = never,
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

    Raises:
      RunError: a checkpoint could not be saved, or none can be read where there should be one.
      Interrupted: the user stopped it.
    """
    started = time.perf_counter()
    evolution = Evolution(config.experiment, evaluator)
    state = _begin(path, evolution, config, reporter)
    with Checkpoints(path / folder.CHECKPOINTS, keep=config.keep) as checkpoints:
        checkpoints.discard_after(int(state.generation))
        try:
            while not _ended(state, config):
                if stopping():
                    raise KeyboardInterrupt
                # Waiting for the disk is part of the generation after.
                after, line = evolution.advance(state, since=started)
                started = time.perf_counter()
                _record(path, checkpoints, after, config, line)
                # Not before its line is written: what Ctrl-C saves below must have one.
                state = after
                reporter.generation(line)
            checkpoints.wait()
            reporter.say("choosing the champion on new terrains")
            return _finish(path, config, evaluator, state)
        except KeyboardInterrupt:
            if int(state.generation) > 0:
                checkpoints.save(int(state.generation), flatten(state))
            checkpoints.wait()
            raise Interrupted(f"stopped after generation {int(state.generation)}") from None


def _begin(path: Path, evolution: Evolution, config: Config, reporter: Reporter) -> RunState:
    """Returns the state to go on from, and cuts the figures of generations that are lost."""
    start = evolution.start(config.seed)
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


def _ended(state: RunState, config: Config) -> bool:
    return bool(state.reached) or int(state.generation) >= config.experiment.generations


def _record(
    path: Path, checkpoints: Checkpoints, state: RunState, config: Config, line: Metrics
) -> None:
    """Adds the generation's line, then starts saving it: a checkpoint never lacks its line."""
    generation = int(state.generation)
    metrics.append(path, line)
    if generation % config.save_every == 0 or _ended(state, config):
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
