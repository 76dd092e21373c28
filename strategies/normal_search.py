"""What strategies have in common that search with one normal distribution over vectors."""

from collections.abc import Callable
from typing import Protocol, TypeVar, runtime_checkable

from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.strategies import checks, vectors
from mjxwalk.strategies.base import Genotype, Strategy, Tree
from mjxwalk.strategies.metrics import SearchMetrics, measure_search


@runtime_checkable
class NormalState(vectors.VectorState, Protocol):
    """A state that has the mean of a distribution."""

    @property
    def mean(self) -> Float[Array, " dim"]:
        """What the population is drawn around."""
        ...


NormalStateT = TypeVar("NormalStateT", bound=NormalState)


def normal_search(
    *,
    population_size: int,
    sigma: Tree,
    init: Callable[[Genotype, Float[Array, " dim"]], NormalStateT],
    tell: Callable[[Float[Array, "pop dim"], Float[Array, " pop"], NormalStateT], NormalStateT],
    deviations: Callable[[NormalStateT], Float[Array, " dim"]] | None = None,
    draw: Callable[[NormalStateT, Float[Array, "pop dim"]], Float[Array, "pop dim"]] | None = None,
    mirrored: bool = False,
) -> Strategy[NormalStateT, SearchMetrics]:
    """Returns the strategy that draws each generation from its state's distribution.

    Args:
      population_size: genotypes in a generation; even if noise is mirrored.
      sigma: standard deviation of generation 0, in units of the weights; one value, or a pytree
        prefix of the template.
      init: makes the first state from a template and the standard deviation of each weight.
      tell: makes the next state from genotypes, fitness and state.
      deviations: standard deviation of each weight in a state; None for `sigma` all the time.
      draw: makes genotypes of standard normal numbers; None for weights that vary independently.
      mirrored: whether the second half of a generation has the noise of the first, negated.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    if mirrored:
        checks.check_even("population_size", population_size)
    else:
        checks.check_count("population_size", population_size, minimum=2)
    checks.check_numbers("sigma", sigma, above=0.0)
    normals = vectors.mirrored_normals if mirrored else vectors.standard_normals

    def init_spread(template: Genotype) -> NormalStateT:
        return init(template, vectors.spread("sigma", sigma, template))

    def spread(state: NormalStateT) -> Float[Array, " dim"]:
        if deviations is None:
            return vectors.spread("sigma", sigma, state.template)
        return deviations(state)

    def ask(key: PRNGKeyArray, state: NormalStateT) -> Float[Array, "pop dim"]:
        noise = normals(key, population_size, state.mean)
        return state.mean + spread(state) * noise if draw is None else draw(state, noise)

    def tell_measured(
        genotypes: Float[Array, "pop dim"], fitness: Float[Array, " pop"], state: NormalStateT
    ) -> tuple[NormalStateT, SearchMetrics]:
        return tell(genotypes, fitness, state), measure_search(fitness, spread(state))

    return vectors.over_vectors(
        population_size=population_size, init=init_spread, ask=ask, tell=tell_measured
    )
