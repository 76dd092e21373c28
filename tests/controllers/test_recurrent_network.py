"""The units of recurrent networks, against equations written once more in numpy."""

from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import robots
from mjxwalk.controllers import RecurrentNetwork
from mjxwalk.envs import MjcfEnv

ENV = MjcfEnv.of(robots.text("walker2d"))


def sigmoid(values: Any) -> Any:
    return 1.0 / (1.0 + np.exp(-values))


def gru(weights: Any, units: Any, inputs: Any) -> Any:
    """Cho et al. (2014), equations 5 to 8, with biases; rows are reset, update, candidate."""
    of_inputs, of_units, bias = (
        np.split(np.asarray(each, np.float64), 3)
        for each in (weights.inputs, weights.units, weights.bias)
    )
    reset, update = (
        sigmoid(of_inputs[gate] @ inputs + of_units[gate] @ units + bias[gate]) for gate in (0, 1)
    )
    candidate = np.tanh(of_inputs[2] @ inputs + of_units[2] @ (reset * units) + bias[2])
    return update * units + (1.0 - update) * candidate


def elman(weights: Any, units: Any, inputs: Any) -> Any:
    """Elman (1990): units see inputs and themselves one action before."""
    return np.tanh(weights.inputs @ inputs + weights.units @ units + weights.bias)


@pytest.mark.parametrize("cell", ["elman", "gru"])
def test_units_follow_their_equations(cell: Literal["elman", "gru"]) -> None:
    policy = RecurrentNetwork(cell=cell, units=6).on(ENV)
    draws = np.random.default_rng(2)
    weights = jax.tree.map(
        lambda leaf: 0.5 * draws.normal(size=leaf.shape).astype(np.float32), policy.template()
    )
    memory = policy.recall(weights)
    expected = np.zeros((2, 6))
    for _ in range(5):
        seen = draws.normal(size=(2, len(policy.layout.inputs))).astype(np.float32)
        phase = draws.uniform(0.0, 6.0, size=2).astype(np.float32)
        memory, rows = policy.respond(weights, memory, jnp.asarray(seen), jnp.asarray(phase))
        for side in (0, 1):
            clock = [max(np.sin(phase[side]), 0.0), np.cos(phase[side])]
            inputs = np.concatenate([seen[side], clock])
            kind = gru if cell == "gru" else elman
            expected[side] = kind(weights, expected[side], inputs)
            asked = weights.outputs @ expected[side] + weights.direct @ inputs + weights.centre
            np.testing.assert_allclose(rows[side], asked, atol=2e-5)  # float32 sums of some dozen
        np.testing.assert_allclose(memory, expected, atol=2e-6)


def test_at_first_units_drive_nothing() -> None:
    policy: Any = RecurrentNetwork().on(ENV)
    weights = policy.template()
    seen = jnp.ones((2, len(policy.layout.inputs)))
    phase = jnp.asarray([1.0, 1.0 + jnp.pi])
    busy = jnp.full((2, policy.units), 0.7)
    _, silent = policy.respond(weights, policy.recall(weights), seen, phase)
    _, stirred = policy.respond(weights, busy, seen, phase)
    np.testing.assert_array_equal(silent, stirred)
    np.testing.assert_allclose(silent[0], np.sin(1.0) * np.array(policy.lift), atol=1e-6)
