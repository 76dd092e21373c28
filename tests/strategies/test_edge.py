"""Tests of what callers may give a strategy: every kind of array, and dtypes that stay."""

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from evosax.algorithms import SNES  # pyright: ignore

from mjxwalk import strategies
from mjxwalk.strategies import Strategy, edge, map_elites

SIZE = 8
BOUNDS: dict[str, Any] = {"lower": -2.0, "upper": 2.0}
OPTIONS: dict[str, dict[str, Any]] = {
    "ars": {"sigma": 0.3, "learning_rate": np.float64(0.1)},
    "bipop-cma-es": {"sigma": 0.5, "max_doublings": 1},
    "cma-es": {"sigma": np.float64(0.5)},
    "deep-ga": {"sigma": 0.1, "initial_sigma": 0.5},
    "hybrid-ga": {**BOUNDS, "breeding_generations": 2},
    "ipop-cma-es": {"sigma": 0.5, "max_doublings": 1},
    "openai-es": {"sigma": 0.3, "optimizer": np.float64(0.1)},
    "pattern-search": {"initial_mesh": 0.5},
    "pgpe": {"sigma": 0.5, "sigma_learning_rate": np.float64(0.1)},
    "self-adaptive-ga": {"sigma": 0.1, "initial_sigma": 0.5},
    "sep-cma-es": {"sigma": 0.5},
    "snes": {"sigma": 0.5, "mean_learning_rate": np.float64(1.0)},
    "truncation-ga": BOUNDS,
    "two-point-ga": {**BOUNDS, "crossover_fraction": 0.8},
    "xnes": {"sigma": 0.5},
}
PRUNING = {"links": -1, "every": 2, "reference": 2, "window": 2, "settle": 2}
WRAPPERS: dict[str, Callable[[Strategy[Any, Any]], Strategy[Any, Any]]] = {
    "alone": lambda strategy: strategy,
    "bounds": lambda strategy: strategies.with_bounds(strategy, **BOUNDS),
    "islands": lambda strategy: strategies.with_islands(
        strategy, num_islands=2, every=2, num_migrants=1
    ),
    "mask": lambda strategy: strategies.with_mask(strategy, {"a": True, "b": False}),
    "pruning": functools.partial(strategies.with_pruning, **PRUNING),
    "restarts": lambda strategy: strategies.with_restarts(strategy, after=2, below=1e9),
    "schedule": lambda strategy: strategies.with_schedule(lambda _: strategy, jnp.float32),
}
TEMPLATES: dict[str, Any] = {
    "float32": {"a": jnp.ones((2, 2), jnp.float32), "b": jnp.ones(3, jnp.float32)},
    "bfloat16": {"a": jnp.ones((2, 2), jnp.bfloat16), "b": jnp.ones(3, jnp.bfloat16)},
    "float16": {"a": np.ones((2, 2), np.float16), "b": np.ones(3, np.float16)},
    "float64": {"a": np.ones((2, 2)), "b": np.ones(3)},
    "numbers": {"a": [1.0, np.float64(2.0), [3.0]], "b": np.ones(3, np.float32)},
}
every_strategy = pytest.mark.parametrize("name", OPTIONS)
FAST = ("snes", "truncation-ga")  # others take longer to compile, and have the same edge
SLOW = [pytest.param(name, marks=pytest.mark.slow) for name in OPTIONS if name not in FAST]
every_strategy_compiled = pytest.mark.parametrize("name", [*FAST, *SLOW])
RANKS = [3, 1, 4, 1, 5, 9, 2, 6]
KINDS: dict[str, Any] = {
    "a list": [float(rank) for rank in RANKS],
    "whole numbers": RANKS,
    "NumPy float32": np.array(RANKS, np.float32),
    "NumPy float64": np.array(RANKS, np.float64),
    "NumPy int64": np.array(RANKS, np.int64),
    "unsigned": np.array(RANKS, np.uint8),
    "unsigned of JAX": jnp.array(RANKS, jnp.uint32),
    "float16": np.array(RANKS, np.float16),
    "bfloat16": jnp.array(RANKS, jnp.bfloat16),
    "arrays in a list": [jnp.float32(rank) for rank in RANKS],
}


def _make(name: str, population_size: int = SIZE) -> Strategy[Any, Any]:
    return strategies.make(name, population_size=population_size, **OPTIONS[name])


def _compiled(name: str) -> Strategy[Any, Any]:
    made = _make(name)
    # With the edge in front of what is compiled, as one compilation serves all kinds of arrays.
    return dataclasses.replace(
        made, init=jax.jit(made.init), ask=jax.jit(made.ask), tell=jax.jit(made.tell)
    )


def _assert_same_bits(got: Any, expected: Any) -> None:
    for a, b in zip(jax.tree.leaves(got), jax.tree.leaves(expected), strict=True):
        assert a.dtype == b.dtype
        assert np.asarray(a).tobytes() == np.asarray(b).tobytes()


def test_every_registered_strategy_is_tested_here() -> None:
    assert set(OPTIONS) == set(strategies.FACTORIES)


@every_strategy
@pytest.mark.parametrize("wrapper", WRAPPERS)
def test_every_strategy_and_wrapper_has_the_edge(name: str, wrapper: str) -> None:
    strategy: Any = WRAPPERS[wrapper](_make(name))
    assert strategy.init.func is edge.init
    assert strategy.ask.func is edge.ask
    assert strategy.tell.func is edge.tell


@every_strategy_compiled
def test_fitness_of_every_kind_gives_the_same_bits(name: str) -> None:
    strategy = _compiled(name)
    state = strategy.init(jax.random.key(0), TEMPLATES["float32"])
    population, state = strategy.ask(jax.random.key(1), state)
    key = jax.random.key(2)
    expected, _ = strategy.tell(key, population, jnp.array(RANKS, jnp.float32), state)
    given = jax.tree.map(lambda leaf: np.asarray(leaf, np.float64), (population, state))
    held = jax.tree.map(lambda leaf, like: leaf.astype(like.dtype), given, (population, state))
    for fitness in KINDS.values():
        _assert_same_bits(strategy.tell(key, population, fitness, state)[0], expected)
    _assert_same_bits(strategy.tell(key, given[0], np.array(RANKS), held[1])[0], expected)
    came = np.array(RANKS) > 3
    expected, _ = strategy.tell(key, population, jnp.asarray(came, jnp.float32), state)
    _assert_same_bits(strategy.tell(key, population, came, state)[0], expected)


@every_strategy
@pytest.mark.parametrize("wrapper", WRAPPERS)
def test_a_scan_keeps_every_dtype_where_x64_is_on(name: str, wrapper: str) -> None:
    with jax.enable_x64(True):
        strategy = WRAPPERS[wrapper](_make(name))
        every = wrapper == "alone" and name in (*FAST, "cma-es")
        for kind, template in TEMPLATES.items():
            if kind != "float32" and not every:
                continue
            population, _ = jax.eval_shape(
                functools.partial(_generations, strategy, template), jax.random.key(0)
            )
            for got, weights in zip(
                jax.tree.leaves(population), jax.tree.leaves(template), strict=True
            ):
                assert got.dtype == jnp.result_type(np.asarray(weights))


def test_algorithms_of_evosax_keep_every_dtype_where_x64_is_on() -> None:
    template = TEMPLATES["float32"]
    with jax.enable_x64(True):
        strategy = strategies.from_evosax(SNES(SIZE, template))
        run = functools.partial(_generations, strategy, template)
        population, _ = jax.eval_shape(run, jax.random.key(0))
    assert {leaf.dtype for leaf in jax.tree.leaves(population)} == {np.dtype(np.float32)}


def _generations(strategy: Strategy[Any, Any], template: Any, key: Any) -> Any:
    """Returns what is asked for after some generations; nothing of it has to run."""

    def generation(state: Any, key: Any) -> tuple[Any, None]:
        key_ask, key_tell = jax.random.split(key)
        population, state = strategy.ask(key_ask, state)
        fitness = sum(
            -jnp.sum(leaf.reshape(len(leaf), -1) ** 2, 1) for leaf in jax.tree.leaves(population)
        )
        return strategy.tell(key_tell, population, fitness, state)[0], None

    state, _ = jax.lax.scan(generation, strategy.init(key, template), jax.random.split(key, 3))
    return strategy.ask(key, state)


def test_whole_numbers_of_64_bits_are_not_cut() -> None:
    got = edge.as_floats("fitness", np.array([2**40, 1], np.int64))
    np.testing.assert_array_equal(got, [2.0**40, 1.0])


def test_what_is_no_fitness_is_refused_in_a_sentence() -> None:
    strategy = _compiled("snes")
    state = strategy.init(jax.random.key(0), TEMPLATES["float32"])
    population = {"a": np.zeros((SIZE, 2, 2)), "b": np.zeros((SIZE, 3))}
    wrong: dict[str, Any] = {
        r"fitness must have shape \(8,\), got \(7,\)": np.zeros(7),
        r"fitness must have shape \(8,\), got \(8, 1\)": np.zeros((SIZE, 1)),
        r"fitness must have shape \(8,\), got \(\)": 1.0,
        "fitness must hold real numbers, got complex64": np.zeros(SIZE, np.complex64),
        "fitness must hold real numbers, got <U1": ["a"] * SIZE,
        "fitness must hold real numbers, got object": None,
        "fitness must be an array of numbers, got list": [[1.0], [1.0, 2.0]],
    }
    key = jax.random.key(1)
    for message, fitness in wrong.items():
        with pytest.raises(ValueError, match=message):
            strategy.tell(key, population, fitness, state)
    with pytest.raises(ValueError, match=r"population\['b'\] must have shape \(8, 3\), got \(3,\)"):
        strategy.tell(key, {**population, "b": np.zeros(3)}, np.zeros(SIZE), state)
    with pytest.raises(ValueError, match="population must be a pytree"):
        strategy.tell(key, np.zeros((SIZE, 7)), np.zeros(SIZE), state)
    number: Any = 0
    with pytest.raises(
        ValueError, match=r"key must be a random key, as jax.random.key\(0\), got 0"
    ):
        strategy.ask(number, state)
    for template in ([1, 2], np.zeros(3, int), "a", [True], np.zeros(2, complex)):
        with pytest.raises(ValueError, match="must be an array of floats, got"):
            strategy.init(key, template)


def test_behaviour_may_be_a_list() -> None:
    strategy = map_elites(
        population_size=4, initial_sigma=1.0, lower=[0.0], upper=[1.0], num_bins=[4]
    )
    state = strategy.init(jax.random.key(0), np.zeros(2))
    population, state = strategy.ask(jax.random.key(1), state)
    key, told = jax.random.key(2), np.asarray(population, np.float64)
    where = [[0.1], [0.2], [0.6], [0.9]]
    given = strategy.tell_behaviour(key, told, [1, 2, 3, 4], where, state)
    usual = jnp.array([1.0, 2.0, 3.0, 4.0]), jnp.array(where)
    _assert_same_bits(given, strategy.tell_behaviour(key, population, *usual, state))
    with pytest.raises(ValueError, match=r"behaviour must have shape \(4, 1\), got \(4,\)"):
        strategy.tell_behaviour(key, told, [1, 2, 3, 4], [1, 2, 3, 4], state)


def test_evosax_loops_may_tell_unsigned_costs_and_numpy_arrays() -> None:
    algorithm = strategies.to_evosax(_make("snes"), np.ones(2))
    state = algorithm.init(jax.random.key(0), np.ones(2))
    population, state = algorithm.ask(jax.random.key(1), state)
    key = jax.random.key(2)
    expected, _ = algorithm.tell(key, population, jnp.array(RANKS, jnp.float32), state)
    told, costs = np.asarray(population, np.float64), np.array(RANKS, np.uint8)
    got, _ = algorithm.tell(key, told, costs, state)
    _assert_same_bits(got, expected)
