"""Tests of one step of each strategy that searches with a distribution, against numpy."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest

from mjxwalk import strategies
from mjxwalk.strategies.evolution_paths import cma_rates
from mjxwalk.strategies.xnes import default_learning_rate

START = np.array([1.0, -2.0], np.float32)
NOISE = np.array([[1.0, 0.5], [-0.5, 2.0], [-1.0, -0.5], [0.5, -2.0]], np.float32)
FITNESS = jnp.array([4.0, 2.0, 1.0, 3.0])
CENTRED = np.array([0.5, -1 / 6, -0.5, 1 / 6])
KEY = jax.random.key(0)


def _utilities() -> np.ndarray:
    raw = np.array([np.log(3.0), 0.0, 0.0, np.log(1.5)])
    return raw / raw.sum() - 0.25


def _told(strategy: strategies.Strategy[Any, Any], sigma: float) -> Any:
    @jax.jit
    def tell(population: jax.Array) -> Any:
        state = strategy.init(KEY, jnp.asarray(START))
        return strategy.tell(KEY, population, FITNESS, state)[0]

    return tell(jnp.asarray(START + sigma * NOISE))


def test_openai_es_follows_the_mean_of_rank_times_noise_over_sigma():
    state = _told(strategies.openai_es(population_size=4, sigma=0.5, optimizer=optax.sgd(1.0)), 0.5)
    expected = START + CENTRED @ NOISE / (4 * 0.5)
    np.testing.assert_allclose(state.mean, expected, rtol=1e-5)


def test_snes_moves_mean_and_sigma_by_algorithm_6():
    state = _told(strategies.snes(population_size=4, sigma=0.5, sigma_learning_rate=0.3), 0.5)
    u = _utilities()
    np.testing.assert_allclose(state.mean, START + 0.5 * u @ NOISE, rtol=1e-5)
    expected = 0.5 * np.exp(0.15 * (u @ (NOISE**2 - 1)))
    np.testing.assert_allclose(state.sigma, expected, rtol=1e-5)


def test_xnes_moves_mean_sigma_and_axes_by_algorithm_5():
    state = _told(strategies.xnes(population_size=4, sigma=0.5), 0.5)
    u, rate = _utilities(), (9 + 3 * np.log(2)) / (5 * 2 * np.sqrt(2))  # table 1
    matrix = np.einsum("i,ij,ik->jk", u, NOISE, NOISE) - u.sum() * np.eye(2)
    growth = np.trace(matrix) / 2
    values, basis = np.linalg.eigh(rate / 2 * (matrix - growth * np.eye(2)))
    np.testing.assert_allclose(state.mean, START + 0.5 * u @ NOISE, rtol=1e-5)
    np.testing.assert_allclose(state.sigma, 0.5 * np.exp(rate / 2 * growth), rtol=1e-5)
    expected = (basis * np.exp(values)) @ basis.T
    np.testing.assert_allclose(state.axes, expected, rtol=1e-4, atol=1e-6)


def test_xnes_learns_faster_from_more_genotypes_and_no_faster_than_separably():
    assert default_learning_rate(40, 15) == pytest.approx(0.01587, rel=1e-3)  # table 1, by hand
    assert default_learning_rate(40, 30) == pytest.approx(2 * 0.015865, rel=1e-3)
    assert default_learning_rate(40, 10_000) == pytest.approx(0.21153, rel=1e-3)  # that of SNES


def test_pgpe_moves_mean_and_sigma_by_pairs():
    strategy = strategies.pgpe(
        population_size=4, sigma=0.5, optimizer=optax.sgd(1.0), sigma_learning_rate=0.1
    )
    state = _told(strategy, 0.5)
    plus, minus = CENTRED[:2], CENTRED[2:]
    steps = 0.5 * NOISE[:2]
    np.testing.assert_allclose(state.mean, START + (plus - minus) / 2 @ steps / 2, rtol=1e-5)
    change = 0.1 * ((plus + minus) / 2 @ (NOISE[:2] ** 2 - 1)) / 2
    np.testing.assert_allclose(state.sigma, 0.5 * (1 + change), rtol=1e-5)


def test_ars_uses_the_best_directions_over_their_deviation():
    strategy = strategies.ars(population_size=4, sigma=0.5, learning_rate=0.1, used_fraction=0.5)
    state = _told(strategy, 0.5)
    # The first pair has the highest fitness on either side, 4 and 1: their deviation is 1.5.
    expected = START + 0.1 * (4.0 - 1.0) * NOISE[0] / (1 * 1.5)
    np.testing.assert_allclose(state.mean, expected, rtol=1e-5)


@pytest.mark.parametrize(("population_size", "num_weights"), [(6, 3), (12, 10), (15, 40)])
def test_constants_of_cma_es_are_those_of_its_authors_package(
    population_size: int, num_weights: int
):
    cma = pytest.importorskip("cma")
    options = {"popsize": population_size, "verbose": -9}
    theirs = cma.CMAEvolutionStrategy(np.zeros(num_weights), 1.0, options)
    ours = cma_rates(population_size, num_weights)
    np.testing.assert_allclose(ours.effective_parents, theirs.sp.weights.mueff, rtol=1e-6)
    np.testing.assert_allclose(ours.rank_one, theirs.sp.c1, rtol=1e-6)
    np.testing.assert_allclose(ours.rank_many, theirs.sp.cmu, rtol=1e-6)
    np.testing.assert_allclose(ours.path_decay, theirs.sp.cc, rtol=1e-6)
    better = np.asarray(theirs.sp.weights.positive_weights)
    np.testing.assert_allclose(ours.weights[: ours.num_parents], better, rtol=1e-6)


def test_cma_es_finds_the_minimum_of_a_turned_ellipsoid():
    turn, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(5, 5)))
    scales = 10.0 ** np.linspace(0, 2, 5)
    strategy = strategies.cma_es(population_size=12, sigma=1.0)

    @jax.jit
    def run(key: jax.Array) -> jax.Array:
        def generation(state: Any, key: jax.Array) -> tuple[Any, jax.Array]:
            key_ask, key_tell = jax.random.split(key)
            population, state = strategy.ask(key_ask, state)
            cost = jnp.sum((population @ turn * scales) ** 2, axis=1)
            return strategy.tell(key_tell, population, -cost, state)[0], jnp.min(cost)

        state = strategy.init(key, jnp.ones(5))
        return jax.lax.scan(generation, state, jax.random.split(key, 200))[1]

    # It starts near 10,000, and its axes differ by 100: without turning axes it gets nowhere.
    assert run(jax.random.key(1))[-1] < 1e-8
