"""Fitness of whole populations, from a function that tries one genotype."""

from collections.abc import Callable
from typing import TypeAlias

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.strategies import checks
from mjxwalk.strategies.base import Genotype, Population

Trial: TypeAlias = Callable[[PRNGKeyArray, Genotype], Float[Array, ""]]
Evaluate: TypeAlias = Callable[[PRNGKeyArray, Population], Float[Array, " pop"]]


def evaluator(
    trial: Trial,
    *,
    num_trials: int = 1,
    common: bool = True,
    over_trials: Callable[..., Array] = jnp.mean,
) -> Evaluate:
    """Returns the function that tries every genotype of a population several times.

    With common random numbers all genotypes meet the same luck, trial by trial, so that
    differences of fitness are differences of genotypes: Heikes, Montgomery & Rardin (1976), "Using
    common random numbers in simulation experiments", Simulation 27(3):81-85.

    Args:
      trial: fitness of one genotype in one trial; uses up its key.
      num_trials: trials of each genotype.
      common: whether all genotypes get the same keys; else each has its own.
      over_trials: makes one fitness of several; takes `axis`. NaN should stay NaN.

    Raises:
      ValueError: num_trials is not a positive count.
    """
    checks.check_count("num_trials", num_trials, minimum=1)
    each_trial = jax.vmap(trial, in_axes=(0, None))

    def evaluate(key: PRNGKeyArray, population: Population) -> Float[Array, " pop"]:
        population = jax.tree.map(jnp.asarray, population)
        size = jax.tree.leaves(population)[0].shape[0]
        if common:
            keys = jax.random.split(key, num_trials)
            fitness = jax.vmap(each_trial, in_axes=(None, 0))(keys, population)
        else:
            fitness = jax.vmap(each_trial)(jax.random.split(key, (size, num_trials)), population)
        return over_trials(fitness, axis=1)

    return evaluate
