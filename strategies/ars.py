"""Augmented random search: mirrored noise, of which only the best directions count.

Mania, Guy & Recht (2018), "Simple random search of static linear policies is competitive for
reinforcement learning", https://arxiv.org/abs/1803.07055, algorithm 1. Its versions V1-t and V2-t
are this strategy with fewer directions used than drawn, V1 and V2 with all. V2 besides has linear
policies see their observations whitened: `with_observations` keeps the statistics for that.
"""

import functools
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks, ranks, vectors
from mjxwalk.strategies.base import Genotype, ScalarLike, Strategy, Tree
from mjxwalk.strategies.metrics import SearchMetrics, measure_search
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


class _Settings(NamedTuple):
    """Checked arguments of `ars`, with what follows from them."""

    population_size: int
    num_used: int
    sigma: Tree
    learning_rate: ScalarLike


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
    checks.check_even("population_size", population_size)
    checks.check_numbers("sigma", sigma, above=0.0)
    checks.check_numbers("learning_rate", learning_rate, above=0.0)
    checks.check_numbers("used_fraction", used_fraction, above=0.0, maximum=1.0)
    num_used = max(1, round(used_fraction * (population_size // 2)))
    settings = _Settings(population_size, num_used, sigma, learning_rate)
    return vectors.over_vectors(
        population_size=population_size,
        init=functools.partial(_init, settings),
        ask=functools.partial(_ask, settings),
        tell=functools.partial(_tell, settings),
    )


def _init(settings: _Settings, template: Genotype) -> ARSState:
    vectors.spread("sigma", settings.sigma, template)  # to refuse what does not fit
    return ARSState(
        mean=vectors.flatten(template),
        template=template,
        generation=jnp.zeros((), jnp.int32),
    )


def _ask(settings: _Settings, key: PRNGKeyArray, state: ARSState) -> Float[Array, "pop dim"]:
    sigma = vectors.spread("sigma", settings.sigma, state.template)
    noise = vectors.mirrored_normals(key, settings.population_size, state.mean)
    return state.mean + sigma * noise


def _tell(
    settings: _Settings,
    genotypes: Float[Array, "pop dim"],
    fitness: Float[Array, " pop"],
    state: ARSState,
) -> tuple[ARSState, SearchMetrics]:
    sigma = vectors.spread("sigma", settings.sigma, state.template)
    num_pairs = settings.population_size // 2
    reward = ranks.finite(fitness).astype(state.mean.dtype)
    used = truncation_selection(
        jnp.maximum(reward[:num_pairs], reward[num_pairs:]), settings.num_used
    )
    plus, minus = reward[used], reward[used + num_pairs]
    directions = (genotypes[used] - genotypes[used + num_pairs]) / (2 * sigma)
    # Scaled first, so that no square of a difference leaves float32.
    middle = (jnp.mean(plus) + jnp.mean(minus)) / 2
    largest = jnp.max(jnp.abs(jnp.concatenate([plus, minus]) - middle))
    weights, deviation = _standardise(plus - middle, minus - middle, largest)
    step = weights @ directions / (settings.num_used * deviation)
    new_state = state._replace(
        mean=state.mean + settings.learning_rate * step, generation=state.generation + 1
    )
    return new_state, measure_search(fitness, sigma)


def _standardise(
    plus: Float[Array, " used"], minus: Float[Array, " used"], largest: Float[Array, ""]
) -> tuple[Float[Array, " used"], Float[Array, ""]]:
    """Returns differences of centred rewards and their deviation, both over the largest; 0 and 1
    if all are equal."""
    scale = jnp.where(largest > 0, largest, 1.0)
    deviation = jnp.std(jnp.concatenate([plus, minus]) / scale)
    return (plus - minus) / scale, jnp.where(deviation > 0, deviation, 1.0)
