"""A strategy of one's own, in one file: it is registered, and experiments evolve by its name."""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import pytest
import toy
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk import experiments, strategies
from mjxwalk.envs import Trials
from mjxwalk.experiments.experiment import StrategyChoice
from mjxwalk.strategies import FitnessMetrics, Genotype, Strategy, vectors

NAME = "hill-climber"


class HillClimberState(NamedTuple):
    """The best genotype so far, as a vector, and its fitness."""

    best: Float[Array, " dim"]
    best_fitness: Float[Array, ""]
    template: Genotype


def hill_climber(
    *, population_size: int, sigma: float
) -> Strategy[HillClimberState, FitnessMetrics]:
    """Returns a search that draws each generation around the best genotype of all before."""

    def init(template: Genotype) -> HillClimberState:
        return HillClimberState(vectors.flatten(template), jnp.full((), -jnp.inf), template)

    def ask(key: PRNGKeyArray, state: HillClimberState) -> Float[Array, "pop dim"]:
        return state.best + sigma * vectors.standard_normals(key, population_size, state.best)

    def tell(
        genotypes: Float[Array, "pop dim"], fitness: Float[Array, " pop"], state: HillClimberState
    ) -> tuple[HillClimberState, FitnessMetrics]:
        fittest = jnp.nanargmax(fitness)
        new = HillClimberState(genotypes[fittest], fitness[fittest], state.template)
        told = FitnessMetrics(strategies.summarise_fitness(fitness))
        return jax.lax.cond(fitness[fittest] > state.best_fitness, lambda: new, lambda: state), told

    return strategies.over_vectors(population_size=population_size, init=init, ask=ask, tell=tell)


@pytest.fixture(autouse=True)
def _registered() -> None:
    """Registers the strategy for each test of this file alone."""
    strategies.register(NAME, hill_climber)


def test_an_experiment_makes_it_by_name_and_its_controller_s_mask_holds():
    lpd = experiments.get("planar-lpd")
    choice = StrategyChoice(name=NAME, options={"sigma": 0.1})
    experiment = dataclasses.replace(lpd, strategy=choice, population_size=6)
    strategy = experiment.make_strategy()
    state = strategy.init(jax.random.key(0), experiment.template())
    population, _ = strategy.ask(jax.random.key(1), state)
    for weights, mask in zip(
        jax.tree.leaves(population), jax.tree.leaves(experiment.controller.mask()), strict=True
    ):
        assert weights.shape[0] == 6
        assert not jnp.any(jnp.where(mask, 0.0, weights))


def test_it_evolves_any_pytree_by_the_experiment_s_own_rollouts():
    experiment = toy.Toy(strategy=StrategyChoice(name=NAME, options={"sigma": 0.2}))
    strategy = experiment.make_strategy()
    trial = Trials(jnp.zeros((1, 1))).given(jnp.zeros((), int))

    def generation(state: Any, key: Any) -> tuple[Any, Any]:
        key_ask, key_tell = jax.random.split(key)
        population, state = strategy.ask(key_ask, state)
        outcome = jax.vmap(experiment.rollout, in_axes=(0, None))(population, trial)
        return strategy.tell(key_tell, population, outcome.fitness, state)

    @jax.jit
    def run(key: Any) -> tuple[Any, Any]:
        state = strategy.init(key, experiment.template())
        return jax.lax.scan(generation, state, jax.random.split(key, 60))

    state, metrics = run(jax.random.key(0))
    # The hidden point is at a squared distance of 7 from the start.
    assert metrics.fitness.best_fitness[0] < -3
    assert state.best_fitness > -0.1
    assert state.best_fitness == jnp.max(metrics.fitness.best_fitness)


@pytest.mark.parametrize(
    ("name", "options", "sentence"),
    [
        ("hil-climber", {}, "unknown strategy 'hil-climber'; did you mean hill-climber?"),
        (NAME, {"sigm": 1.0}, "unknown option 'sigm' of hill-climber; did you mean sigma?"),
        (NAME, {}, "hill-climber needs a value for sigma"),
    ],
)
def test_what_is_wrong_is_said_as_of_our_own(name: str, options: dict[str, Any], sentence: str):
    with pytest.raises(ValueError) as error:
        strategies.make(name, population_size=6, **options)
    assert str(error.value) == sentence


def _takes_anything(**options: Any) -> Any:
    raise NotImplementedError


def _makes_no_strategy(*, population_size: int) -> Any:
    return population_size


def test_what_cannot_be_registered_is_refused_in_one_sentence():
    with pytest.raises(ValueError, match="there is a strategy 'snes' already; choose another name"):
        strategies.register("snes", hill_climber)
    with pytest.raises(ValueError, match="factory of odd must take population_size and each"):
        strategies.register("odd", _takes_anything)
    with pytest.raises(ValueError, match="factory of odd must take population_size and each"):
        strategies.register("odd", lambda: hill_climber(population_size=2, sigma=1.0))
    strategies.register(NAME, _makes_no_strategy)
    with pytest.raises(ValueError, match="factory of hill-climber must make a Strategy, got 6"):
        strategies.make(NAME, population_size=6)
