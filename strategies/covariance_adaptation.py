"""What CMA-ES with a full and with a diagonal covariance matrix have in common.

Hansen (2023), "The CMA evolution strategy: a tutorial", https://arxiv.org/abs/1604.00772 version 2,
figure 6. The matrix is in the states of `cma_es` and `sep_cma_es`, which draw with it and learn it;
`evolution_paths` has the constants and the paths.
"""

from collections.abc import Callable
from typing import Protocol, TypeVar, runtime_checkable

import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.strategies.base import Genotype, Strategy, Tree
from mjxwalk.strategies.evolution_paths import Rates, cma_rates
from mjxwalk.strategies.metrics import SearchMetrics
from mjxwalk.strategies.normal_search import NormalState, normal_search
from mjxwalk.strategies.operators import best_first


@runtime_checkable
class CMAState(NormalState, Protocol):
    """A state that has a covariance matrix."""

    def deviations(self) -> Float[Array, " dim"]:
        """Returns the standard deviation of each weight."""
        ...

    def draw(self, noise: Float[Array, "pop dim"]) -> Float[Array, "pop dim"]:
        """Returns the genotypes that standard normal numbers stand for."""
        ...


CMAStateT = TypeVar("CMAStateT", bound=CMAState)


def cma_search(
    start: Callable[[Genotype, Float[Array, ""], Float[Array, " dim"]], CMAStateT],
    advance: Callable[[CMAStateT, Float[Array, "pop dim"], Rates], CMAStateT],
    *,
    population_size: int,
    sigma: Tree,
    separable: bool,
) -> Strategy[CMAStateT, SearchMetrics]:
    """Returns CMA-ES with the covariance matrix that a state has.

    Args:
      start: makes the first state from a template, the step size and each weight's standard
        deviation.
      advance: makes the state after a generation, whose genotypes are given best first.
      population_size: see `cma_es`.
      sigma: see `cma_es`.
      separable: whether the covariance matrix is diagonal.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """

    def init(template: Genotype, deviations: Float[Array, " dim"]) -> CMAStateT:
        return start(template, jnp.exp(jnp.mean(jnp.log(deviations))), deviations)

    def tell(
        genotypes: Float[Array, "pop dim"], fitness: Float[Array, " pop"], state: CMAStateT
    ) -> CMAStateT:
        rates = cma_rates(population_size, state.mean.size, separable=separable)
        return advance(state, genotypes[best_first(fitness)], rates)

    return normal_search(
        population_size=population_size,
        sigma=sigma,
        init=init,
        tell=tell,
        deviations=lambda state: state.deviations(),
        draw=lambda state, noise: state.draw(noise),
    )
