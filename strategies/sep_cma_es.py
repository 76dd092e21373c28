"""CMA-ES with a diagonal covariance matrix: linear in the number of weights.

Ros & Hansen (2008), "A simple modification in CMA-ES achieving linear time and space complexity",
PPSN X, https://hal.inria.fr/inria-00287367, section 3. Constants are those of the later tutorial,
Hansen (2023), https://arxiv.org/abs/1604.00772 version 2, learnt faster by Ros and Hansen's factor.
evosax 0.3 leaves that factor out, which is slower where weights differ in scale, and with small
populations a little more robust where there are many local minima.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from mjxwalk.strategies import vectors
from mjxwalk.strategies.base import Genotype, Strategy, Tree
from mjxwalk.strategies.covariance_adaptation import cma_search
from mjxwalk.strategies.evolution_paths import Paths, Rates, advance_paths
from mjxwalk.strategies.metrics import SearchMetrics


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

    def deviations(self) -> Float[Array, " dim"]:
        """Returns the standard deviation of each weight."""
        return self.sigma * self.lengths

    def draw(self, noise: Float[Array, "pop dim"]) -> Float[Array, "pop dim"]:
        """Returns the genotypes that standard normal numbers stand for."""
        return self.mean + self.sigma * self.lengths * noise


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
    return cma_search(_start, advance, population_size=population_size, sigma=sigma, separable=True)


def _start(
    template: Genotype, sigma: Float[Array, ""], deviations: Float[Array, " dim"]
) -> SepCMAESState:
    mean = vectors.flatten(template)
    return SepCMAESState(
        mean=mean,
        sigma=sigma,
        lengths=deviations / sigma,
        paths=Paths(jnp.zeros_like(mean), jnp.zeros_like(mean)),
        template=template,
        generation=jnp.zeros((), jnp.int32),
    )


def advance(state: SepCMAESState, ordered: Float[Array, "pop dim"], rates: Rates) -> SepCMAESState:
    """Returns the state after a generation, of which all genotypes are given, best first."""
    weights = jnp.maximum(jnp.asarray(rates.weights[: rates.num_parents], state.mean.dtype), 0)
    steps = (ordered[: rates.num_parents] - state.mean) / state.sigma
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
