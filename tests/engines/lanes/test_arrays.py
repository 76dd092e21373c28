"""Large matrix products, and what is computed from them, are loops over arrays in memory."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.engines import lanes, lanes_xla
from mjxwalk.engines.lanes.frontend.tracing import trace
from mjxwalk.engines.lanes.ir.arrays import IN_MEMORY
from mjxwalk.engines.lanes.ir.signature import Argument

WALKERS = 19  # no multiple of any width


def draws(*shape: int, seed: int = 0) -> Any:
    return np.random.default_rng(seed).normal(0, 0.3, (WALKERS, *shape)).astype(np.float32)


def perceptron(weights: Any, x: Any) -> Any:
    first, bias, last = weights
    return jnp.tanh(first @ x + bias) @ last


def from_the_left(weights: Any, x: Any) -> Any:
    first, bias, last = weights
    return jnp.tanh(x @ first.T + bias) @ last


def of_both_sides(weights: Any, x: Any) -> Any:
    first, bias, last = weights
    return jax.nn.elu(jnp.stack([x, x[::-1]]) @ first.T + bias) @ last


def of_a_column(weights: Any, x: Any) -> Any:
    first, bias, last = weights
    return (jax.nn.relu(first @ x[:, None] + bias[:, None]).T @ last)[0]


def normalised(weights: Any, x: Any) -> Any:
    first, bias, last = weights
    sums = jnp.stack([x, x * x]) @ first.T + bias
    off = sums - jnp.mean(sums, axis=1, keepdims=True)
    return off / jnp.sqrt(jnp.mean(off**2, axis=1, keepdims=True) + 1e-5) @ last


def masked(weights: Any, x: Any) -> Any:
    first, bias, last = weights
    kept = np.arange(70) % 3 > 0
    found = first @ x + bias
    return jnp.where(kept, found, jnp.where(found > bias, -found, 0.1)) @ last


def sliced(weights: Any, x: Any) -> Any:
    first, bias, last = weights
    found = jnp.sin((first @ x)[::-1] + bias)
    return found[3:60] @ last[3:60] + found[0] * jnp.max(found)


def remembering(weights: Any, x: Any) -> Any:
    """The steps that a walker takes depend on the walker, so that lanes are refilled."""
    first, bias, last = weights
    before = jnp.tanh(first @ x)  # before the loop, and read after it

    def step(state: Any) -> Any:
        count, hidden, seen = state
        hidden = jnp.tanh(first @ seen + bias + 0.5 * hidden)
        return count + 1, hidden, jnp.tanh(hidden @ last[:, :1] + seen)

    steps = 3 + jnp.int32(jnp.abs(x[0]) * 20)
    found = jax.lax.while_loop(lambda s: s[0] < steps, step, (0, jnp.zeros(70), x))
    return found[1] @ last + before[:4]


def waiting(weights: Any, x: Any) -> Any:
    """A loop in a loop; the inner one runs for some walkers longer than for others."""
    first, bias, last = weights

    def inner(state: Any) -> Any:
        count, seen = state
        return count + 1, jnp.tanh(jnp.tanh(first @ seen + bias) @ last)[0] + 0.9 * seen

    def outer(state: Any) -> Any:
        count, seen = state
        most = 1 + jnp.int32(jnp.abs(seen[1]) * 9) % 4
        return count + 1, jax.lax.while_loop(lambda s: s[0] < most, inner, (0, seen))[1]

    return jax.lax.while_loop(lambda s: s[0] < 5, outer, (0, x))[1][:4]


FUNCTIONS = [
    perceptron, from_the_left, of_both_sides, of_a_column, normalised, masked, sliced, remembering,
    waiting,
]  # fmt: skip


def drawn() -> Any:
    return (draws(70, 33), draws(70, seed=1), draws(70, 4, seed=2)), draws(33, seed=3)


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda f: f.__name__)
def test_results_are_those_of_jax(function: Callable[..., Any]) -> None:
    weights, x = drawn()
    expected = jax.jit(jax.vmap(function))(weights, x)
    for width in (8, 16) if function in (of_both_sides, waiting) else (4,):
        found = lanes.vmap(function, width=width, threads=2)(weights, x)
        np.testing.assert_allclose(found, expected, rtol=2e-5, atol=2e-5)


@pytest.mark.parametrize("function", [of_both_sides, masked, waiting], ids=lambda f: f.__name__)
def test_the_graph_for_accelerators_gives_the_same(function: Callable[..., Any]) -> None:
    weights, x = drawn()
    expected = jax.jit(jax.vmap(function))(weights, x)
    np.testing.assert_allclose(lanes_xla.vmap(function)(weights, x), expected, rtol=2e-5, atol=2e-5)


def test_all_walkers_may_share_weights() -> None:
    weights, x = drawn()
    shared = jax.tree.map(lambda leaf: leaf[0], weights)
    expected = jax.jit(jax.vmap(perceptron, (None, 0)))(shared, x)
    np.testing.assert_allclose(
        lanes.vmap(perceptron, (None, 0))(shared, x), expected, rtol=2e-5, atol=2e-5
    )
    np.testing.assert_allclose(
        lanes_xla.vmap(perceptron, (None, 0))(shared, x), expected, rtol=2e-5, atol=2e-5
    )


def test_numbers_of_64_bits_are_summed_as_such() -> None:
    with jax.enable_x64(True):
        first, x = draws(70, 33).astype(np.float64), draws(33, seed=3).astype(np.float64)

        def function(first: Any, x: Any) -> Any:
            return jnp.maximum(first @ x, 0.1) * 2.0

        expected = np.maximum(np.einsum("wij,wj->wi", first, x), 0.1) * 2.0
        np.testing.assert_allclose(lanes.vmap(function)(first, x), expected, rtol=1e-13)


def test_an_input_that_is_not_finite_stays_in_its_row() -> None:
    weights, x = drawn()
    weights[1][:, 5] = np.inf
    x[2, 0] = np.nan
    expected = jax.jit(jax.vmap(lambda w, x: jnp.tanh(w[0] @ x + w[1])))(weights, x)
    found = lanes.vmap(lambda w, x: jnp.tanh(w[0] @ x + w[1]))(weights, x)
    np.testing.assert_allclose(found, expected, rtol=2e-5, atol=2e-5)


def num_nodes(hidden: int) -> int:
    """Returns how many nodes a network comes to that are not numbers of its arrays."""

    def function(first: Any, second: Any, x: Any) -> Any:
        return jnp.tanh(second @ jnp.tanh(first @ x))[0]

    shapes = (hidden, 20), (hidden, hidden), (20,)
    arguments = [Argument(shape, "float32", False, False) for shape in shapes]
    tree = jax.tree.structure(((0, 0, 0), {}))
    nodes = trace(function, tree, arguments).graph.nodes
    assert sum(node.op in IN_MEMORY for node in nodes) == 4  # two of each layer
    return sum(node.op != "element" for node in nodes)


def test_the_code_of_a_layer_does_not_grow_with_its_size() -> None:
    assert num_nodes(256) == num_nodes(64) < 30


def test_a_small_product_is_written_out() -> None:
    graph = trace(
        lambda a, x: a @ x,
        jax.tree.structure(((0, 0), {})),
        [Argument((10, 10), "float32", False, False), Argument((10,), "float32", False, False)],
    ).graph
    assert not any(node.op in IN_MEMORY for node in graph.nodes)


def test_a_table_of_truths_is_read() -> None:
    table = np.arange(50) % 3 == 0
    places = np.arange(WALKERS, dtype=np.int32)
    found = lanes.vmap(lambda place: jnp.asarray(table)[place])(places)
    np.testing.assert_array_equal(found, table[:WALKERS])
