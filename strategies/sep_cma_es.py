"""CMA-ES with a diagonal covariance matrix: linear in the number of weights.

Ros & Hansen (2008), "A simple modification in CMA-ES achieving linear time and space complexity",
PPSN X, https://hal.inria.fr/inria-00287367, section 3. Constants are those of the later tutorial,
Hansen (2023), https://arxiv.org/abs/1604.00772 version 2, learnt faster by Ros and Hansen's factor.
evosax 0.3 leaves that factor out, which is slower where weights differ in scale, and with small
populations a little more robust where there are many local minima.
"""

import functools
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks, vectors
from mjxwalk.strategies.base import Genotype, Population, Strategy, Tree
from mjxwalk.strategies.evolution_paths import Paths, Rates, advance_paths, cma_rates
from mjxwalk.strategies.metrics import SearchMetrics, measure_search
from mjxwalk.strategies.operators import truncation_selection


class SepCMAESState(NamedTuple):
    """State between generations.

    Attributes:
      mean: what the population is drawn around, as one vector; see `vectors.unflatten`.
      sigma: step size.
      lengths: standard deviation of each weight over the step size.
      paths: cumulated steps of the mean.
      template: genotype that the search started from.
      generation: number of the generation to be evaluated next.
    """

    mean: Float[Array, " dim"]
    sigma: Float[Array, ""]
    lengths: Float[Array, " dim"]
    paths: Paths
    template: Genotype
    generation: Int[Array, ""]


class _Settings(NamedTuple):
    """Checked arguments of `sep_cma_es`."""

    population_size: int
    sigma: Tree


def sep_cma_es(*, population_size: int, sigma: Tree) -> Strategy[SepCMAESState, SearchMetrics]:
    """Returns separable CMA-ES, Ros & Hansen (2008), section 3; all else follows from these.

    Genotypes of equal fitness keep their order, which is that of their random draws.

    Args:
      population_size: genotypes in a generation.
      sigma: standard deviation of generation 0, in units of the weights; one value, or a pytree
        prefix of the template.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_count("population_size", population_size, minimum=2)
    checks.check_numbers("sigma", sigma, above=0.0)
    settings = _Settings(population_size, sigma)
    return Strategy(
        population_size=population_size,
        init=functools.partial(_init, settings),
        ask=functools.partial(_ask, settings),
        tell=functools.partial(_tell, settings),
    )


def _init(settings: _Settings, key: PRNGKeyArray, template: Genotype) -> SepCMAESState:
    del key
    mean = vectors.flatten(template)
    scales = vectors.spread("sigma", settings.sigma, template)
    sigma = jnp.exp(jnp.mean(jnp.log(scales)))
    return SepCMAESState(
        mean=mean,
        sigma=sigma,
        lengths=scales / sigma,
        paths=Paths(jnp.zeros_like(mean), jnp.zeros_like(mean)),
        template=template,
        generation=jnp.zeros((), jnp.int32),
    )


def _ask(
    settings: _Settings, key: PRNGKeyArray, state: SepCMAESState
) -> tuple[Population, SepCMAESState]:
    noise = vectors.standard_normals(key, settings.population_size, state.mean)
    genotypes = state.mean + state.sigma * state.lengths * noise
    return vectors.unflatten_population(genotypes, state.template), state


def _tell(
    settings: _Settings,
    key: PRNGKeyArray,
    population: Population,
    fitness: Float[Array, " pop"],
    state: SepCMAESState,
) -> tuple[SepCMAESState, SearchMetrics]:
    del key
    rates = cma_rates(settings.population_size, state.mean.size, separable=True)
    parents = truncation_selection(fitness, rates.num_parents)
    new_state = advance(state, vectors.flatten_population(population)[parents], rates)
    return new_state, measure_search(fitness, deviations(state))


def deviations(state: SepCMAESState) -> Float[Array, " dim"]:
    """Returns the standard deviation of each weight."""
    return state.sigma * state.lengths


def advance(
    state: SepCMAESState, parents: Float[Array, "parents dim"], rates: Rates
) -> SepCMAESState:
    """Returns the state after a generation.

    Args:
      state: that it was drawn from.
      parents: its best genotypes, best first, as many as may have a weight above 0.
      rates: constants.
    """
    weights = jnp.maximum(jnp.asarray(rates.weights[: rates.num_parents], state.mean.dtype), 0)
    steps = (parents - state.mean) / state.sigma
    step = weights @ steps
    paths, regained, growth = advance_paths(
        state.paths, step, step / state.lengths, state.generation, rates
    )
    variances = (
        (1 - rates.rank_one - rates.rank_many + regained) * state.lengths**2
        + rates.rank_one * paths.covariance**2
        + rates.rank_many * (weights @ steps**2)
    )
    return state._replace(
        mean=state.mean + state.sigma * step,
        sigma=vectors.bound_sigma(state.sigma * growth),
        lengths=vectors.bound_sigma(jnp.sqrt(variances)),
        paths=paths,
        generation=state.generation + 1,
    )
