"""How far strategies get, on functions by evaluations and on walkers by physics steps."""

import dataclasses
import functools
from collections.abc import Iterator
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from mjxwalk import strategies
from mjxwalk.bench import searches
from mjxwalk.bench.functions import FUNCTIONS
from mjxwalk.strategies import Strategy

SIGMA = 1.0  # of generation 0; starts are uniform in a cube of sides 6
BOUNDS = {"lower": -3.0, "upper": 3.0}  # that cube
# Settings for functions, of strategies that need more than a sigma.
ON_FUNCTIONS: dict[str, dict[str, Any]] = {
    "ars": {"sigma": searches.NARROW_SIGMA, "learning_rate": searches.LEARNING_RATE},
    "deep-ga": {"sigma": searches.NARROW_SIGMA, "initial_sigma": SIGMA},
    "hybrid-ga": BOUNDS,
    "openai-es": {"sigma": searches.NARROW_SIGMA, "optimizer": searches.LEARNING_RATE},
    "pattern-search": {"initial_mesh": SIGMA},
    "pgpe": {"sigma": SIGMA, "optimizer": searches.LEARNING_RATE},
    "self-adaptive-ga": {"sigma": searches.NARROW_SIGMA, "initial_sigma": SIGMA},
    "truncation-ga": BOUNDS,
    "two-point-ga": BOUNDS,
}
# Settings for walkers that no other strategy has; weights of walkers are of the order of 1.
ON_WALKERS: dict[str, dict[str, Any]] = {
    "hybrid-ga": BOUNDS,
    "pattern-search": {"initial_mesh": 0.5},
    "truncation-ga": BOUNDS,
    "two-point-ga": BOUNDS,
}


class LearningCurve(NamedTuple):
    """What one strategy did in one task from one seed.

    Attributes:
      task: function and its number of weights, or experiment.
      strategy: by name.
      seed: of it.
      effort: evaluations of a function, or millions of physics steps, so far.
      reached: lowest value so far, or fitness of the generation's best, at each of these.
    """

    task: str
    strategy: str
    seed: int
    effort: list[float]
    reached: list[float]


def on_functions(
    name: str, num_weights: int, seeds: int, evaluations: int
) -> Iterator[LearningCurve]:
    """Returns the curves of a strategy on all functions."""
    size = searches.usual_population(num_weights)
    options = ON_FUNCTIONS.get(name, {"sigma": SIGMA})
    strategy = strategies.make(name, population_size=size, **options)
    starts = searches.start_points(seeds, num_weights)
    found = searches.lowest(strategy, starts, max(1, evaluations // size), FUNCTIONS)
    for function, values in found.items():
        for seed, value in enumerate(values):
            yield LearningCurve(
                f"{function} {num_weights}", name, seed, [evaluations], [float(value)]
            )


def with_strategy(experiment: Any, name: str) -> Any:
    """Returns an experiment with another strategy, which keeps the settings that it takes too.

    Raises:
      ValueError: the strategy does not exist, or needs more settings.
    """
    options = strategies.carry_over(name, experiment.strategy.options)
    choice = dataclasses.replace(
        experiment.strategy, name=name, options=options | ON_WALKERS.get(name, {})
    )
    if name == experiment.strategy.name:
        return experiment
    return dataclasses.replace(experiment, strategy=choice)


def on_walkers(experiment: Any, evaluator: Any, seed: int, million_steps: float) -> LearningCurve:
    """Returns the curve of an experiment's strategy until its walkers have taken so many steps.

    Args:
      experiment: with the strategy.
      evaluator: of the experiment.
      seed: of all random numbers.
      million_steps: of the physics.
    """
    strategy: Strategy[Any, Any] = experiment.make_strategy()
    ask, tell = jax.jit(strategy.ask), jax.jit(strategy.tell)
    key_init, key_run = jax.random.split(jax.random.key(seed))
    state = jax.jit(strategy.init)(key_init, experiment.template())
    sample = jax.jit(
        functools.partial(experiment.sample_trials, num=experiment.terrains_per_evaluation)
    )
    effort: list[float] = []
    reached: list[float] = []
    steps = 0
    while steps < 1e6 * million_steps:
        keys = jax.random.split(jax.random.fold_in(key_run, len(effort)), 3)
        population, state = ask(keys[0], state)
        outcome = evaluator.evaluate(population, sample(keys[1]))
        fitness = np.mean(outcome.fitness, axis=1, dtype=np.float64).astype(np.float32)
        state, _ = tell(keys[2], population, jnp.asarray(fitness), state)
        steps += int(np.sum(outcome.steps, dtype=np.int64))
        effort.append(steps / 1e6)
        reached.append(float(np.max(np.nan_to_num(fitness, nan=-np.inf, neginf=-np.inf))))
    return LearningCurve(experiment.name, experiment.strategy.name, seed, effort, reached)
