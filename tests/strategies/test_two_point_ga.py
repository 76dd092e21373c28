"""The operators by hand, and the rates that the thesis contradicts itself about."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compiled import compiled

from mjxwalk.strategies import two_point_ga
from mjxwalk.strategies.two_point_ga import (
    expected_parents,
    stochastic_remainder,
    two_point_crossover,
)

TEMPLATE = jnp.zeros(12)


def test_whole_parts_of_expectations_are_certain_and_the_rest_is_drawn():
    """By hand: 2, 0 and 1 are certain; the wheel has 0.2 of the first and 0.8 of the second."""
    expected = jnp.array([2.2, 0.8, 1.0])
    low = stochastic_remainder(expected, jnp.array([0.9, 0.9, 0.9, 0.19]))
    high = stochastic_remainder(expected, jnp.array([0.0, 0.0, 0.0, 0.21]))
    np.testing.assert_array_equal(low, [0, 0, 2, 0])
    np.testing.assert_array_equal(high, [0, 0, 2, 1])


def test_expectations_go_with_the_root_of_the_rank_and_fill_all_places():
    expected = expected_parents(100, 195)
    assert expected.sum() == pytest.approx(195, rel=1e-5)
    assert expected[0] / expected[3] == pytest.approx(2.0)
    # The best of 100 fills a tenth of all places.
    assert expected[0] == pytest.approx(10.5, abs=0.2)


def test_parents_are_chosen_as_often_as_expected_on_average():
    expected = jnp.array([1.5, 0.7, 0.5, 0.3])
    draws = jax.random.uniform(jax.random.key(0), (20_000, 3))
    chosen = jax.jit(jax.vmap(lambda u: stochastic_remainder(expected, u)))(draws)
    counts = np.bincount(np.asarray(chosen).ravel(), minlength=4) / 20_000
    # A share of 20,000 draws has a deviation of at most 0.005 a place, two places are drawn.
    np.testing.assert_allclose(counts, expected, atol=0.03)


@pytest.mark.parametrize(
    ("draws", "expected"),
    [
        ([0.2, 0.6], [0, 0, 1, 1, 0]),  # points 2 and 4
        ([0.6, 0.2], [0, 0, 1, 1, 0]),  # in the other order
        ([0.0, 0.999], [0, 1, 1, 1, 1]),  # points 1 and 5
        ([0.5, 0.5], [0, 0, 0, 0, 0]),  # equal: a copy
    ],
)
def test_what_lies_between_two_points_is_from_the_second_parent(
    draws: list[float], expected: list[int]
):
    child = two_point_crossover(jnp.zeros(5), jnp.ones(5), jnp.array(draws))
    np.testing.assert_array_equal(child, expected)


def test_a_single_weight_is_the_first_parents():
    child = two_point_crossover(jnp.zeros(1), jnp.ones(1), jnp.array([0.3, 0.9]))
    np.testing.assert_array_equal(child, [0.0])


@functools.cache
def _generation(crossover_fraction: float, mutation_rate: float) -> tuple[np.ndarray, np.ndarray]:
    strategy = two_point_ga(
        population_size=100,
        lower=0.0,
        upper=1.0,
        crossover_fraction=crossover_fraction,
        mutation_rate=mutation_rate,
    )
    strategy = compiled(strategy)
    state = strategy.init(jax.random.key(0), TEMPLATE)
    before, state = strategy.ask(jax.random.key(1), state)
    state, _ = strategy.tell(jax.random.key(2), before, jnp.sum(before, axis=1), state)
    after, _ = strategy.ask(jax.random.key(3), state)
    return np.asarray(before), np.asarray(after)


def test_generation_0_fills_the_bounds():
    before, _ = _generation(0.99, 0.01)
    assert before.shape == (100, 12)
    assert 0.0 <= before.min() < 0.01
    assert 0.99 < before.max() < 1.0


def test_the_two_best_are_copied_to_the_front():
    before, after = _generation(0.99, 0.01)
    order = np.argsort(-before.sum(axis=1))
    np.testing.assert_array_equal(after[:2], before[order[:2]])


def _num_new(before: np.ndarray, after: np.ndarray) -> int:
    """Returns how many genotypes have a weight that nobody had in that place."""
    return int((~(after[:, None, :] == before[None, :, :]).any(axis=1)).any(axis=1).sum())


def test_the_texts_crossover_fraction_leaves_one_offspring_to_mutation_and_the_tables_none():
    assert _num_new(*_generation(0.99, 1.0)) == 1
    assert _num_new(*_generation(0.999, 1.0)) == 0


def test_bounds_may_differ_between_weights():
    strategy = two_point_ga(
        population_size=50, lower=0.0, upper=jnp.where(jnp.arange(12) < 8, 1.0, 10.0)
    )
    population = np.asarray(compiled(strategy).init(jax.random.key(0), TEMPLATE).population)
    assert population[:, :8].max() <= 1.0
    assert population[:, 8:].max() > 5.0


def test_the_template_can_be_kept():
    strategy = two_point_ga(population_size=5, lower=1.0, upper=2.0, keep_template=True)
    population = np.asarray(compiled(strategy).init(jax.random.key(0), TEMPLATE).population)
    np.testing.assert_array_equal(population[0], TEMPLATE)
    assert population[1:].min() >= 1.0


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("crossover_fraction", 1.1, "crossover_fraction must be .* got 1.1"),
        ("mutation_rate", -0.1, "mutation_rate must be .* got -0.1"),
        ("num_elites", -1, "num_elites must be .* got -1"),
        ("upper", 0.0, r"upper must be above lower \(0.0\), got 0.0"),
        ("upper", float("inf"), "upper must be finite, got inf"),
    ],
)
def test_a_wrong_setting_is_named(name: str, value: float, message: str):
    given = {"population_size": 10, "lower": 0.0, "upper": 1.0} | {name: value}
    with pytest.raises(ValueError, match=message):
        two_point_ga(**given)  # type: ignore[arg-type]


def test_bounds_that_do_not_fit_the_template_are_refused():
    strategy = two_point_ga(population_size=10, lower=0.0, upper=jnp.ones(3))
    with pytest.raises(ValueError, match="upper must broadcast to the template's shape"):
        strategy.init(jax.random.key(0), TEMPLATE)
