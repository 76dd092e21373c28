"""Tests of ClipUp and of what follows gradients with it, against the paper in float64 NumPy."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest

from mjxwalk import strategies
from mjxwalk.strategies import clipup, gradients

KEY = jax.random.key(0)
RTOL = 2e-6  # a few roundings of float32


def _update(optimizer: optax.GradientTransformation, gradient: Any, state: Any) -> tuple[Any, Any]:
    """Returns the step and the next state; optax's own types say less of them."""
    return optimizer.update(gradient, state)


def _published_velocity(
    velocity: np.ndarray, gradient: np.ndarray, rate: float, momentum: float, max_speed: float
) -> np.ndarray:
    """Returns algorithm 1 of Toklu et al. (2020), uphill."""
    pushed = momentum * velocity + rate * gradient / np.linalg.norm(gradient)
    speed = np.linalg.norm(pushed)
    return max_speed * pushed / speed if speed > max_speed else pushed


def _published_pgpe(
    mean: np.ndarray,
    sigma: np.ndarray,
    velocity: np.ndarray,
    noise: np.ndarray,
    fitness: np.ndarray,
    max_speed: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns mean, sigma and velocity after a step of PGPE of the same paper, section 2.

    Args:
      mean: of the population.
      sigma: of it.
      velocity: of ClipUp.
      noise: of each pair, in units of sigma.
      fitness: of all first ones of the pairs, then of all second ones.
      max_speed: of ClipUp; half of it is the learning rate.
    """
    worth = np.argsort(np.argsort(fitness)) / (fitness.size - 1) - 0.5
    plus, minus = np.split(worth, 2)
    steps = sigma * noise
    of_mean = np.zeros_like(mean)
    of_sigma = np.zeros_like(mean)
    for step, one, other in zip(steps, plus, minus, strict=True):
        of_mean += (one - other) / 2 * step
        of_sigma += ((one + other) / 2 - worth.mean()) * (step**2 - sigma**2) / sigma
    velocity = _published_velocity(velocity, of_mean, max_speed / 2, 0.9, max_speed)
    changed = sigma + 0.1 * of_sigma / len(steps)
    changed = np.clip(changed, 0.8 * sigma, 1.2 * sigma)
    return mean + velocity, changed, velocity


def test_steps_are_those_of_the_paper_and_as_long_as_the_settings_say() -> None:
    optimizer = clipup(0.2, 0.5, momentum=0.9)
    state: Any = optimizer.init(jnp.zeros(7))
    random = np.random.default_rng(0)
    velocity = np.zeros(7)
    lengths: list[float] = []
    for scale in 10.0 ** random.uniform(-8, 8, size=12):
        gradient = scale * random.normal(size=7)
        velocity = _published_velocity(velocity, gradient, 0.2, 0.9, 0.5)
        updates, state = _update(optimizer, jnp.asarray(-gradient), state)
        np.testing.assert_allclose(updates, velocity, rtol=RTOL, atol=1e-7)
        lengths.append(float(jnp.linalg.norm(jnp.asarray(updates))))
    assert lengths[0] == pytest.approx(0.2, rel=RTOL)
    assert max(lengths) <= 0.5 * (1 + RTOL)


def test_a_step_by_hand() -> None:
    # The gradient (3, 4) has length 5; 0.5 of its direction is (0.3, 0.4), and twice that is cut.
    optimizer = clipup(0.5, 0.6, momentum=1.0)
    first, state = _update(optimizer, jnp.array([3.0, 4.0]), optimizer.init(jnp.zeros(2)))
    np.testing.assert_allclose(first, [-0.3, -0.4], rtol=RTOL)
    second, _ = _update(optimizer, jnp.array([3.0, 4.0]), state)
    np.testing.assert_allclose(second, [-0.36, -0.48], rtol=RTOL)


@pytest.mark.parametrize("size", [0.0, 1e-36, 1e37])  # of float32, squares of which are 0 and inf
def test_no_size_of_a_gradient_spoils_a_step(size: float) -> None:
    optimizer = clipup(0.5, 0.6)
    state = optimizer.init(jnp.zeros(2))
    updates, _ = _update(optimizer, size * jnp.array([1.0, -1.0]), state)
    expected = 0.0 if size == 0.0 else 0.5
    assert float(jnp.linalg.norm(jnp.asarray(updates))) == pytest.approx(expected, rel=RTOL)


def test_a_tree_is_one_vector() -> None:
    optimizer = clipup(0.5, 0.6)
    tree = {"a": jnp.array([3.0]), "b": jnp.array([[0.0, 4.0]])}
    updates: Any = _update(optimizer, tree, optimizer.init(tree))[0]
    np.testing.assert_allclose(updates["b"], [[0.0, -0.4]], rtol=RTOL)


def test_pgpe_with_clipup_goes_as_the_paper_for_ten_generations() -> None:
    num, size = 9, 20
    strategy = strategies.make(
        "pgpe", population_size=size, radius=2.25, optimizer="clipup", max_speed=0.15
    )
    state = strategy.init(KEY, jnp.linspace(-1.0, 1.0, num))
    mean, sigma = np.linspace(-1.0, 1.0, num), np.full(num, 2.25 / np.sqrt(num))
    velocity = np.zeros(num)
    for generation in range(10):
        population, state = strategy.ask(jax.random.key(generation), state)
        drawn = np.asarray(population, np.float64)
        noise = (drawn[: size // 2] - drawn[size // 2 :]) / 2 / sigma
        fitness = -np.sum((drawn - 3.0) ** 2, axis=1)
        mean, sigma, velocity = _published_pgpe(mean, sigma, velocity, noise, fitness, 0.15)
        state, _ = strategy.tell(KEY, population, fitness, state)
        np.testing.assert_allclose(state.mean, mean, rtol=1e-4)  # roundings of ten generations
        np.testing.assert_allclose(state.sigma, sigma, rtol=1e-4)


def test_by_the_radius_alone_clipup_has_the_papers_proportions() -> None:
    strategy = strategies.pgpe(population_size=4, radius=1.5, optimizer="clipup")
    state = strategy.init(KEY, jnp.zeros(4))
    assert float(jnp.linalg.norm(state.sigma)) == pytest.approx(1.5)
    population, state = strategy.ask(KEY, state)
    state, _ = strategy.tell(KEY, population, jnp.arange(4.0), state)
    # A fifteenth of the radius is the maximum speed, and half of that the first step.
    assert float(jnp.linalg.norm(state.mean)) == pytest.approx(0.05, rel=1e-5)


def test_openai_es_takes_optimisers_by_name() -> None:
    def first_step(**options: Any) -> float:
        strategy = strategies.make("openai-es", population_size=4, sigma=0.1, **options)
        state = strategy.init(KEY, jnp.zeros(4))
        population, state = strategy.ask(KEY, state)
        state, _ = strategy.tell(KEY, population, jnp.arange(4.0), state)
        return float(jnp.linalg.norm(state.mean))

    assert first_step(optimizer="clipup") == pytest.approx(0.075, rel=1e-5)
    assert first_step(optimizer="clipup", max_speed=0.3) == pytest.approx(0.15, rel=1e-5)
    assert first_step(optimizer="adam") == first_step() == first_step(optimizer=0.01)
    faster = {"optimizer": "sgd", "learning_rate": 0.02}
    assert first_step(**faster) == pytest.approx(2 * first_step(optimizer="sgd"), rel=1e-5)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"optimizer": "clip"}, "or a name, got 'clip'; did you mean clipup"),
        ({"optimizer": "adam", "max_speed": 0.1}, "optimizer adam has no max_speed"),
        ({"optimizer": 0.1, "momentum": 0.5}, "momentum must be null unless optimizer is a name"),
        ({"optimizer": "clipup", "max_speed": -1.0}, "max_speed must be finite and > 0.0, got -1"),
        ({"optimizer": "sgd", "momentum": 2.0}, "momentum must be .* <= 1.0, got 2.0"),
        ({"weight_decay": -1.0}, "weight_decay must be finite and >= 0.0"),
        ({"sigma": None}, "pgpe needs a value for sigma or for radius"),
    ],
)
def test_wrong_settings_are_named(options: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        strategies.make("pgpe", population_size=4, **{"sigma": 0.1, **options})


@pytest.mark.parametrize("name", ["openai-es", "pgpe"])
def test_weight_decay_is_that_of_openais_starter(name: str) -> None:
    sigma, decay = np.array([0.1, 0.2, 0.4]), 0.005
    options: dict[str, Any] = {"sigma": sigma, "optimizer": optax.sgd(1.0)}
    strategy = strategies.make(name, population_size=6, weight_decay=decay, **options)
    start = np.array([3.0, -2.0, 1.0])
    state = strategy.init(KEY, jnp.asarray(start, jnp.float32))
    population, state = strategy.ask(KEY, state)
    noise = (np.asarray(population, np.float64)[:3] - start) / sigma
    ranks = np.array([0.5, 0.1, -0.1, -0.3, 0.3, -0.5])  # of the fitness below
    # The starter's gradient: centred ranks of the pairs' differences times noise, over all
    # genotypes; its optimiser is given l2coeff * theta less that.
    starters = (ranks[:3] - ranks[3:]) @ noise / 6 - decay * start
    state, _ = strategy.tell(KEY, population, jnp.array([5.0, 3.0, 2.0, 1.0, 4.0, 0.0]), state)
    moved = np.asarray(state.mean, np.float64) - start
    # Ours is the starter's over sigma, that of PGPE the starter's times sigma.
    expected = starters / sigma if name == "openai-es" else starters * sigma
    np.testing.assert_allclose(moved, expected, rtol=1e-4, atol=1e-6)


def test_no_weight_decay_leaves_a_gradient_as_it_is() -> None:
    gradient = jnp.array([1.0, -0.0])
    assert gradients.decayed(gradient, 0.0, gradient, gradient) is gradient
