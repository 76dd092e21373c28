"""Properties that every strategy has; a new one joins by one more entry in `CASES`."""

import functools
import pickle
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import strategies
from mjxwalk.strategies import Strategy, with_pruning


class Case(NamedTuple):
    """A strategy with settings for a problem whose weights are of the order of 1.

    Attributes:
      name: key of the registry.
      options: hyper-parameters besides the population size.
      smallest_population: fewest genotypes that it takes.
      by_rank: whether only the order of fitness counts.
      wrap: makes another strategy of it.
      wrapping: what that is.
    """

    name: str
    options: dict[str, Any]
    smallest_population: int = 2
    by_rank: bool = True
    wrap: Callable[[Strategy[Any, Any]], Strategy[Any, Any]] = lambda strategy: strategy
    wrapping: str = ""


GA = Case("self-adaptive-ga", {"sigma": 0.1, "initial_sigma": 0.5})
# Any template fits, as none of its weights may go; `test_pruning` has those that do.
PRUNING = functools.partial(with_pruning, links=-1, every=2, reference=2, window=2, settle=2)
BOUNDS = {"lower": -2.0, "upper": 2.0}
CASES = [
    GA,
    GA._replace(wrap=PRUNING, wrapping=", pruned"),
    Case("two-point-ga", {**BOUNDS, "crossover_fraction": 0.8, "mutation_rate": 0.1}),
    Case("pattern-search", {"initial_mesh": 0.5}),
    Case("hybrid-ga", {**BOUNDS, "breeding_generations": 2}),
    Case("ars", {"sigma": 0.3, "learning_rate": 0.2}, by_rank=False),
    Case("cma-es", {"sigma": 0.5}),
    # Of the full matrix `test_restarting_cma_es` has as much, and it takes longer to compile.
    Case("ipop-cma-es", {"sigma": 0.5, "max_doublings": 1, "separable": True}),
    Case("bipop-cma-es", {"sigma": 0.5, "max_doublings": 1, "separable": True}),
    Case("openai-es", {"sigma": 0.3, "optimizer": 0.1}),
    Case("pgpe", {"sigma": 0.5, "optimizer": 0.1}),
    Case("sep-cma-es", {"sigma": 0.5}),
    Case("snes", {"sigma": 0.5}),
    Case("snes", {"sigma": 0.5}, wrap=PRUNING, wrapping=", pruned"),
    Case("xnes", {"sigma": 0.5}),
    Case("truncation-ga", {**BOUNDS, "substitutions": 2.0}),
    Case("deep-ga", {"sigma": 0.1, "initial_sigma": 0.5, "num_parents": 5}),
]

POPULATION_SIZE = 20
NUM_GENERATIONS = 30
TEMPLATE = {
    "hip": {"inputs": jnp.ones((2, 2)), "bias": (jnp.ones(()), None)},
    "legs": [jnp.ones(2), {"knee": (jnp.ones((1, 2, 1)),)}],
}
TARGET = -1.0

every_strategy = pytest.mark.parametrize("case", CASES, ids=lambda case: case.name + case.wrapping)


def _make(case: Case, population_size: int) -> Strategy[Any, Any]:
    made = strategies.make(case.name, population_size=population_size, **case.options)
    return case.wrap(made)


@functools.cache
def _compiled(index: int, population_size: int) -> tuple[Strategy[Any, Any], Any]:
    case = CASES[index]
    strategy = _make(case, population_size)
    # One compilation of `tell` serves every test that has the same shapes.
    jitted = Strategy(
        population_size=strategy.population_size,
        init=jax.jit(strategy.init),
        ask=jax.jit(strategy.ask),
        tell=jax.jit(strategy.tell),
    )
    return strategy, jitted


def _compile(case: Case, population_size: int = POPULATION_SIZE) -> Strategy[Any, Any]:
    return _compiled(CASES.index(case), population_size)[1]


def _distance(population: Any) -> Any:
    """Returns each genotype's squared distance to the target."""
    return sum(
        jnp.sum((leaf.reshape(leaf.shape[0], -1) - TARGET) ** 2, axis=1)
        for leaf in jax.tree.leaves(population)
    )


def _generation(strategy: Strategy[Any, Any], key: Any, state: Any) -> tuple[Any, Any]:
    key_ask, key_tell = jax.random.split(key)
    population, state = strategy.ask(key_ask, state)
    return strategy.tell(key_tell, population, -_distance(population), state)


def _evolve(strategy: Strategy[Any, Any], keys: Any, state: Any) -> tuple[Any, list[Any]]:
    metrics: list[Any] = []
    for key in keys:
        state, scalars = _generation(strategy, key, state)
        metrics.append(scalars)
    return state, metrics


def _assert_same_bits(got: Any, expected: Any) -> None:
    assert jax.tree.structure(got) == jax.tree.structure(expected)
    for a, b in zip(jax.tree.leaves(got), jax.tree.leaves(expected), strict=True):
        assert a.dtype == b.dtype
        assert np.asarray(a).tobytes() == np.asarray(b).tobytes()


def _assert_finite(population: Any) -> None:
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(population))


def test_every_registered_strategy_is_tested_here():
    assert {case.name for case in CASES} == set(strategies.FACTORIES)


@every_strategy
def test_population_has_the_templates_structure_and_an_axis_in_front(case: Case):
    strategy = _compile(case)
    population, state = strategy.ask(jax.random.key(1), strategy.init(jax.random.key(0), TEMPLATE))
    assert strategy.population_size == POPULATION_SIZE
    assert jax.tree.structure(population) == jax.tree.structure(TEMPLATE)
    for leaf, weights in zip(jax.tree.leaves(population), jax.tree.leaves(TEMPLATE), strict=True):
        assert leaf.shape == (POPULATION_SIZE, *weights.shape)
        assert leaf.dtype == weights.dtype
    _, metrics = strategy.tell(jax.random.key(2), population, jnp.arange(20.0), state)
    assert all(jnp.shape(scalar) == () for scalar in jax.tree.leaves(metrics))
    assert metrics.fitness.best_fitness == 19


@every_strategy
def test_fitness_is_maximised(case: Case):
    strategy = _compile(case)
    keys = jax.random.split(jax.random.key(1), NUM_GENERATIONS)
    state, metrics = _evolve(strategy, keys, strategy.init(jax.random.key(0), TEMPLATE))
    population, _ = strategy.ask(jax.random.key(2), state)
    # The start is at squared distance 11 x 4; going the other way would raise that.
    assert jnp.median(_distance(population)) < 0.5 * -metrics[0].fitness.median_fitness


@every_strategy
def test_nan_ranks_below_every_number(case: Case):
    if not case.by_rank:
        pytest.skip("the size of fitness counts, so no number stands for NaN")
    strategy = _compile(case)
    state = strategy.init(jax.random.key(0), TEMPLATE)
    population, state = strategy.ask(jax.random.key(1), state)
    number = np.array(-_distance(population))
    number[[0, 3, 11]] = -1e30  # NaN is equal to NaN
    broken = number.copy()
    broken[[0, 3, 11]] = np.nan
    key = jax.random.key(2)
    expected, _ = strategy.tell(key, population, jnp.asarray(number), state)
    got, metrics = strategy.tell(key, population, jnp.asarray(broken), state)
    _assert_same_bits(strategy.ask(key, got)[0], strategy.ask(key, expected)[0])
    assert metrics.fitness.num_nan == 3


@every_strategy
@pytest.mark.parametrize(
    "values",
    [[np.nan], [0.0], [np.inf, 0.0], [-np.inf, 1.0], [np.nan, np.inf, -np.inf, 2.0], [-np.inf]],
    ids=["all NaN", "all tied", "some inf", "some -inf", "a mixture", "all -inf"],
)
def test_no_fitness_spoils_the_next_population(case: Case, values: list[float]):
    strategy = _compile(case)
    state = strategy.init(jax.random.key(0), TEMPLATE)
    for generation in range(3):
        key_ask, key_tell = jax.random.split(jax.random.key(generation))
        population, state = strategy.ask(key_ask, state)
        _assert_finite(population)
        fitness = jnp.resize(jnp.array(values), (POPULATION_SIZE,))
        state, _ = strategy.tell(key_tell, population, fitness, state)
    _assert_finite(strategy.ask(jax.random.key(9), state)[0])


@every_strategy
def test_ties_do_not_depend_on_anything_but_the_key(case: Case):
    strategy = _compile(case)
    state = strategy.init(jax.random.key(0), TEMPLATE)
    population, state = strategy.ask(jax.random.key(1), state)
    fitness = jnp.resize(jnp.array([1.0, 2.0]), (POPULATION_SIZE,))
    key = jax.random.key(2)
    once = strategy.tell(key, population, fitness, state)
    _assert_same_bits(strategy.tell(key, population, fitness, state), once)


@every_strategy
def test_same_key_gives_the_same_bits_and_another_key_others(case: Case):
    strategy = _compile(case)
    ends = [
        _evolve(
            strategy,
            jax.random.split(jax.random.key(seed), 4),
            strategy.init(jax.random.key(seed), TEMPLATE),
        )[0]
        for seed in (0, 0, 1)
    ]
    _assert_same_bits(ends[1], ends[0])
    populations = [strategy.ask(jax.random.key(9), end)[0] for end in ends]
    assert jnp.any(_distance(populations[2]) != _distance(populations[0]))


@every_strategy
def test_resuming_from_a_saved_state_gives_the_same_bits(case: Case):
    strategy = _compile(case)
    keys = jax.random.split(jax.random.key(1), 6)
    state = strategy.init(jax.random.key(0), TEMPLATE)
    expected, _ = _evolve(strategy, keys, state)
    halfway, _ = _evolve(strategy, keys[:3], state)
    saved = pickle.dumps(jax.tree.map(np.asarray, halfway))
    restored = jax.tree.map(jnp.asarray, pickle.loads(saved))
    _assert_same_bits(_evolve(strategy, keys[3:], restored)[0], expected)


@every_strategy
def test_a_scan_over_generations_under_vmap_over_seeds_gives_the_same_as_a_loop(case: Case):
    plain, jitted = _compiled(CASES.index(case), POPULATION_SIZE)
    seeds = jax.random.split(jax.random.key(5), 2)

    @jax.jit
    @jax.vmap
    def run(key: Any) -> Any:
        key_init, key_generations = jax.random.split(key)
        state = plain.init(key_init, TEMPLATE)
        keys = jax.random.split(key_generations, 3)
        return jax.lax.scan(lambda carry, k: _generation(plain, k, carry), state, keys)[0]

    together = run(seeds)
    for index, seed in enumerate(seeds):
        key_init, key_generations = jax.random.split(seed)
        state = jitted.init(key_init, TEMPLATE)
        alone, _ = _evolve(jitted, jax.random.split(key_generations, 3), state)
        for a, b in zip(jax.tree.leaves(together), jax.tree.leaves(alone), strict=True):
            # Another program may round a fused multiply-add differently, a few times in a row, and
            # sum in another order; all here are of the order of 1.
            np.testing.assert_allclose(a[index], b, rtol=1e-5, atol=1e-5)


@every_strategy
def test_no_key_is_used_twice(case: Case):
    plain, _ = _compiled(CASES.index(case), POPULATION_SIZE)

    def run(key: Any) -> Any:
        key_init, key_generation = jax.random.split(key)
        return _generation(plain, key_generation, plain.init(key_init, TEMPLATE))

    with jax.debug_key_reuse(True):
        # The checker works on the traced program, so nothing has to run.
        jax.jit(run).lower(jax.random.key(0))


@every_strategy
@pytest.mark.parametrize(
    "template", [jnp.zeros(()), jnp.zeros((2, 3))], ids=["one weight", "a bare array"]
)
def test_the_smallest_population_moves_any_template(case: Case, template: Any):
    strategy = _compile(case, case.smallest_population)
    state = strategy.init(jax.random.key(0), template)
    keys = jax.random.split(jax.random.key(1), 5)
    first, state = strategy.ask(jax.random.key(2), state)
    state, _ = _evolve(strategy, keys, state)
    last, _ = strategy.ask(jax.random.key(3), state)
    assert last.shape == (case.smallest_population, *template.shape)
    _assert_finite(last)
    assert jnp.any(last != first)


@every_strategy
def test_wrong_shapes_and_templates_are_refused(case: Case):
    plain, strategy = _compiled(CASES.index(case), POPULATION_SIZE)
    state = strategy.init(jax.random.key(0), TEMPLATE)
    population, state = strategy.ask(jax.random.key(1), state)
    with pytest.raises(Exception, match="(?i)fitness"):
        plain.tell(jax.random.key(2), population, jnp.zeros(POPULATION_SIZE + 1), state)
    with pytest.raises(Exception, match="template"):
        plain.init(jax.random.key(0), {"hip": jnp.zeros(3, jnp.int32)})
    with pytest.raises(ValueError, match="template must hold at least one weight"):
        plain.init(jax.random.key(0), {"hip": jnp.zeros((0, 3))})


@every_strategy
@pytest.mark.parametrize("population_size", [0, 1, -4])
def test_a_population_too_small_is_refused(case: Case, population_size: int):
    with pytest.raises(ValueError, match=rf"population_size must be .*got {population_size}"):
        _make(case, population_size)
