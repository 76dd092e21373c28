"""Evaluates populations: every genotype in every trial, by an engine."""

import dataclasses
import functools
from typing import Any, Protocol, runtime_checkable

import jax
import numpy as np

from mjxwalk import engines
from mjxwalk.controllers import Controller
from mjxwalk.controllers.normalisation import Sums
from mjxwalk.engines.pinning import pinned
from mjxwalk.envs import TRIAL_AXES, Trial, Trials
from mjxwalk.rollout import Environment, Outcome, rollout

# Terrains come in tables of a multiple of so many rows, so that engines, which compile for shapes,
# compile once for most numbers of terrains.
TABLE_ROWS = 512

# What a rollout returns, as a tree: of most controllers, and of those that normalise their senses.
OUTCOME = Outcome._make([*range(8), None])
OUTCOME_AND_SENSED = OUTCOME._replace(sensed=Sums._make([8, 9, 10]))


@runtime_checkable
class Task(Protocol):
    """What can be evaluated: an experiment, or the least part of one."""

    def rollout(self, genotype: Any, given: Trial) -> Outcome:
        """Returns what one walker does in one trial."""
        ...


class Evaluator:
    """Runs a task's rollout for populations.

    Attributes:
      engine: name of the engine that runs.
      why: why this engine, in words.
      devices: what it runs on, in words.
    """

    def __init__(self, task: Task, engine: str) -> None:
        choice = engines.choose(engine)
        self.engine, self.why = choice.name, choice.why
        self.devices = choice.engine.devices()
        results = OUTCOME if _nothing_known(task) is None else OUTCOME_AND_SENSED
        self._mapped = choice.engine.vmap(task.rollout, (0, TRIAL_AXES), results=results)

    @property
    def compile_s(self) -> float:
        """Seconds spent compiling so far."""
        return self._mapped.compile_s

    @pinned()
    def prepare(self, population: Any, trials: Any) -> None:
        """Compiles for arguments of `evaluate` of these shapes.

        Args:
          population: anything with the shapes and types of the genotypes.
          trials: anything with those of the trials.
        """
        self._mapped.prepare(*jax.eval_shape(_laid_out, population, trials))

    @pinned()
    def evaluate(self, population: Any, trials: Trials) -> Outcome:
        """Returns the outcomes as numpy arrays [pop, trial].

        Args:
          population: genotypes, leaves [pop, ...].
          trials: that each genotype is given.

        Raises:
          ValueError: there is no genotype or no trial, or leaves differ in how many they hold.
        """
        population = jax.tree.map(_on_host, population)
        trials = jax.tree.map(_on_host, trials, is_leaf=lambda part: isinstance(part, list))
        for name, tree in (("population", population), ("trials", trials)):
            shapes = [leaf.shape for leaf in jax.tree.leaves(tree)]
            sizes = {shape[:1] for shape in shapes}
            if len(sizes) != 1 or sizes & {(), (0,)}:
                what = "genotypes" if name == "population" else "trials"
                raise ValueError(f"{name} must have {what} in front of all leaves, got {shapes}")
        outcome = self._mapped(*_laid_out(population, trials))
        return jax.tree.map(lambda leaf: _of_trials(np.asarray(leaf), trials.num), outcome)


@dataclasses.dataclass(frozen=True)
class Pair:
    """The least task: an environment, and a controller that was told of it."""

    env: Environment
    controller: Controller

    def rollout(self, genotype: Any, given: Trial) -> Outcome:
        """Returns what one walker does in one trial."""
        return rollout(self.env, self.controller, genotype, given)


def evaluate(
    env: Environment,
    controller: Controller,
    genotypes: Any,
    trials: Trials,
    *,
    engine: str = "auto",
) -> Outcome:
    """Returns what every genotype does in every trial, as NumPy's arrays [pop, trial].

    What was compiled for an environment and a controller serves later calls with equal ones.

    Args:
      env: body or task, and the rules of its trials.
      controller: what the genotypes become in it.
      genotypes: leaves [pop, ...], such as a strategy's `ask` returns.
      trials: as `env.sample_trials(key, num)` draws them.
      engine: what runs them, as `mjxwalk evolve --engine` knows it.

    Raises:
      ValueError: there is no such engine, the controller is not one for the environment, or
        genotypes or trials have no such shapes.
    """
    pair = Pair(env, controller.on(env))
    try:
        evaluator = _evaluator(pair, engine)
    except TypeError:  # settings that cannot be hashed, such as a table
        evaluator = Evaluator(pair, engine)
    return evaluator.evaluate(genotypes, trials)


def _nothing_known(task: Any) -> Any:
    """Returns what the task's controller knows of its senses at first; None of one without."""
    controller = getattr(task, "controller", None)
    return None if controller is None else controller.nothing_known()


def _of_trials(values: np.ndarray, num: int) -> np.ndarray:
    """Returns values of walkers as [pop, trial, ...]."""
    return values.reshape(-1, num, *values.shape[1:])


def _laid_out(population: Any, trials: Trials) -> tuple[Any, Trial]:
    """Returns genotypes and trials of all walkers: every genotype in every trial.

    It takes NumPy's arrays and traced ones alike.
    """
    num, size = trials.num, jax.tree.leaves(population)[0].shape[0]
    walker = np.arange(size * num, dtype=np.int32)
    # The rows that fill the table up are nobody's.
    filled = trials.with_grounds(np.minimum(np.arange(_table_rows(num)), num - 1))
    given = filled._replace(heights=filled.heights.astype(np.float32)).given(walker % num)
    return jax.tree.map(lambda leaf: leaf[walker // num], population), given


def _on_host(values: Any) -> np.ndarray:
    """Returns numbers as NumPy's, of the dtype that JAX would give them."""
    array = np.asarray(values)
    return array.astype(jax.dtypes.canonicalize_dtype(array.dtype), copy=False)


def _table_rows(num_terrains: int) -> int:
    return -(-num_terrains // TABLE_ROWS) * TABLE_ROWS


@functools.lru_cache(maxsize=8)
def _evaluator(task: Task, engine: str) -> Evaluator:
    return Evaluator(task, engine)


def make_evaluator(task: Task, engine: str) -> Evaluator:
    """Returns an evaluator of the task by the named engine.

    Raises:
      ValueError: there is no such engine.
    """
    return Evaluator(task, engine)
