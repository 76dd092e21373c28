"""Augmented random search: mirrored noise, of which only the best directions count.

Mania, Guy & Recht (2018), "Simple random search of static linear policies is competitive for
reinforcement learning", https://arxiv.org/abs/1803.07055, algorithm 1. Its versions V1-t and V2-t
are this strategy with fewer directions used than drawn, V1 and V2 with all. V2 besides has linear
policies see their observations whitened: `with_observations` keeps the statistics for that.
"""

import functools
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from mjxwalk.strategies import checks, ranks, vectors
from mjxwalk.strategies.base import Genotype, ScalarLike, Strategy, Tree
from mjxwalk.strategies.metrics import SearchMetrics
from mjxwalk.strategies.normal_search import normal_search
from mjxwalk.strategies.operators import truncation_selection

LEARNING_RATE = 0.02  # the authors' own: step_size in code/ars.py of modestyachts/ARS
USED_FRACTION = 0.5  # ours: the authors' own is 1, V1; V1-t uses fewer


class ARSState(NamedTuple):
    """State between generations.

    Attributes:
      mean: what the population is drawn around, as one vector; see `vectors.unflatten`.
      template: genotype that the search started from.
      generation: number of the generation to be evaluated next.
    """

    mean: Float[Array, " dim"]
    template: Genotype
    generation: Int[Array, ""]


def ars(
    *,
    population_size: int,
    sigma: Tree,
    learning_rate: ScalarLike = LEARNING_RATE,
    used_fraction: float | int = USED_FRACTION,
) -> Strategy[ARSState, SearchMetrics]:
    """Returns augmented random search, Mania et al. (2018), algorithm 1.

    The size of fitness counts: infinity is taken for the highest of its generation's finite
    values, minus infinity and NaN for the lowest.

    Args:
      population_size: genotypes in a generation; even, because noise is mirrored.
      sigma: standard deviation of the noise, the paper's nu, in units of the weights; one value,
        or a pytree prefix of the template.
      learning_rate: the paper's alpha: length of a step, for differences in fitness of one
        standard deviation.
      used_fraction: share of the directions that count, rounded, one at least: those with the best
        fitness on either side. 1 for V1 and V2.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_numbers("learning_rate", learning_rate, above=0.0)
    checks.check_numbers("used_fraction", used_fraction, above=0.0, maximum=1.0)
    return normal_search(
        population_size=population_size,
        sigma=sigma,
        init=_init,
        tell=functools.partial(_tell, sigma, learning_rate, used_fraction),
        mirrored=True,
    )


def _init(template: Genotype, deviations: Float[Array, " dim"]) -> ARSState:
    del deviations
    return ARSState(
        mean=vectors.flatten(template),
        template=template,
        generation=jnp.zeros((), jnp.int32),
    )


def _tell(
    sigma: Tree,
    learning_rate: ScalarLike,
    used_fraction: float | int,
    genotypes: Float[Array, "pop dim"],
    fitness: Float[Array, " pop"],
    state: ARSState,
) -> ARSState:
    deviations = vectors.spread("sigma", sigma, state.template)
    num_pairs = fitness.size // 2
    num_used = max(1, round(used_fraction * num_pairs))
    reward = ranks.finite(fitness).astype(state.mean.dtype)
    used = truncation_selection(jnp.maximum(reward[:num_pairs], reward[num_pairs:]), num_used)
    plus, minus = reward[used], reward[used + num_pairs]
    directions = (genotypes[used] - genotypes[used + num_pairs]) / (2 * deviations)
    # Scaled first, so that no square of a difference leaves float32.
    middle = (jnp.mean(plus) + jnp.mean(minus)) / 2
    largest = jnp.max(jnp.abs(jnp.concatenate([plus, minus]) - middle))
    weights, deviation = _standardise(plus - middle, minus - middle, largest)
    step = weights @ directions / (num_used * deviation)
    return state._replace(mean=state.mean + learning_rate * step, generation=state.generation + 1)


def _standardise(
    plus: Float[Array, " used"], minus: Float[Array, " used"], largest: Float[Array, ""]
) -> tuple[Float[Array, " used"], Float[Array, ""]]:
    """Returns differences of centred rewards and their deviation, both over the largest; 0 and 1
    if all are equal."""
    scale = jnp.where(largest > 0, largest, 1.0)
    deviation = jnp.std(jnp.concatenate([plus, minus]) / scale)
    return (plus - minus) / scale, jnp.where(deviation > 0, deviation, 1.0)
