"""The interface that every strategy has: three pure functions and a population size.

    strategy = self_adaptive_ga(population_size=150, sigma=0.05, initial_sigma=0.05)
    state = strategy.init(key_init, template)
    population, state = strategy.ask(key_ask, state)
    state, metrics = strategy.tell(key_tell, population, evaluate(population), state)

The shape is optax's: a factory checks hyper-parameters and returns a bundle of functions. The order
of arguments is evosax's. Fitness is maximised, and NaN ranks below minus infinity.
"""

import dataclasses
import functools
from typing import (
    TYPE_CHECKING,
    Any,
    Generic,
    Protocol,
    TypeAlias,
    TypeVar,
    runtime_checkable,
)

import jax
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from mjxwalk.strategies import edge

# A static checker cannot describe a pytree and takes jaxtyping's `PyTree` for an error, so it is
# shown `Any`; the tests check the real types.
if TYPE_CHECKING:
    Tree: TypeAlias = Any
    FloatTree: TypeAlias = Any
    IntTree: TypeAlias = Any
    BoolTree: TypeAlias = Any
    Population: TypeAlias = Any
    Masks: TypeAlias = Any
else:
    from jaxtyping import PyTree

    Tree = PyTree
    FloatTree = PyTree[Float[Array, "..."]]
    IntTree = PyTree[Int[Array, "..."]]
    BoolTree = PyTree[Bool[Array, "..."]]
    Population = PyTree[Float[Array, "pop ..."]]
    Masks = PyTree[Bool[Array, "pop ..."]]

Genotype: TypeAlias = FloatTree
Mask: TypeAlias = BoolTree

# A number, or an array without axes: one that is traced lets `vmap` run over a hyper-parameter.
ScalarLike: TypeAlias = float | int | Float[Array, ""]

StateT = TypeVar("StateT")
MetricsT = TypeVar("MetricsT")
StateT_co = TypeVar("StateT_co", covariant=True)
MetricsT_co = TypeVar("MetricsT_co", covariant=True)


@runtime_checkable
class Init(Protocol[StateT_co]):
    """Makes the state of generation 0 from a template: any pytree of float arrays."""

    def __call__(self, key: PRNGKeyArray, template: Genotype, /) -> StateT_co:
        """Returns the state before anything is evaluated; uses up `key`."""
        ...


@runtime_checkable
class Ask(Protocol[StateT]):
    """Hands out the genotypes to evaluate."""

    def __call__(self, key: PRNGKeyArray, state: StateT, /) -> tuple[Population, StateT]:
        """Returns the template's pytree with a population axis in front; uses up `key`."""
        ...


@runtime_checkable
class Tell(Protocol[StateT, MetricsT_co]):
    """Takes the fitness in and makes the next state."""

    def __call__(
        self,
        key: PRNGKeyArray,
        population: Population,
        fitness: Any,
        state: StateT,
        /,
    ) -> tuple[StateT, MetricsT_co]:
        """Returns the next state and scalars about the generation told; uses up `key`.

        Args:
          key: random key, different from the one `ask` had.
          population: genotypes from `ask`, in the same order; JAX's arrays or NumPy's.
          fitness: one value a genotype, higher is better, NaN is worst; an array or a list.
          state: state from `ask`.
        """
        ...


# Not a NamedTuple: as a pytree JAX would take its functions for arrays, and beartype cannot check a
# generic one (https://github.com/beartype/beartype/issues/519).
@dataclasses.dataclass(frozen=True, kw_only=True)
class Strategy(Generic[StateT, MetricsT]):
    """A strategy: pure functions that `jit`, `vmap` over seeds and run under `lax.scan`.

    The state after `tell` is all that is needed to go on, so a checkpoint is that state and a key.
    The functions given need to know JAX's arrays alone: `edge` converts what callers give, and
    keeps the dtypes of the state.

    Attributes:
      population_size: genotypes in a generation.
      init: makes the first state.
      ask: gives the population to evaluate.
      tell: turns population and fitness into the next state.
    """

    population_size: int
    init: Init[StateT]
    ask: Ask[StateT]
    tell: Tell[StateT, MetricsT]

    def __post_init__(self) -> None:
        asked = jax.jit(self.ask)
        edges = {"init": edge.init, "ask": edge.ask, "tell": edge.tell}
        for name, function in edges.items():
            own = getattr(self, name)
            # A strategy made of another's functions, as by `dataclasses.replace`, has them already.
            if getattr(own, "func", None) is not function:
                more = (asked, self.population_size) if name == "tell" else ()
                object.__setattr__(self, name, functools.partial(function, own, *more))
