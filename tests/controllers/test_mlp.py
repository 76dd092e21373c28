"""The perceptron, against its layers written once more in numpy."""

from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import robots
from mjxwalk.controllers import Mlp
from mjxwalk.envs import MjcfEnv

ENV = MjcfEnv.of(robots.text("walker2d"))
ACTIVATIONS: dict[str, Any] = {
    "tanh": np.tanh,
    "relu": lambda values: np.where(values > 0.0, values, 0.0),
    "elu": lambda values: np.where(values > 0.0, values, np.expm1(values)),
}


@pytest.mark.parametrize("layer_norm", [False, True])
@pytest.mark.parametrize("activation", list(ACTIVATIONS))
def test_layers_follow_their_equations(
    activation: Literal["tanh", "relu", "elu"], layer_norm: bool
) -> None:
    policy = Mlp(hidden=(7, 5), activation=activation, layer_norm=layer_norm).on(ENV)
    draws = np.random.default_rng(3)
    weights = jax.tree.map(
        lambda leaf: 0.5 * draws.normal(size=leaf.shape).astype(np.float32), policy.template()
    )
    seen = draws.normal(size=(2, len(policy.layout.inputs))).astype(np.float32)
    phase = np.array([0.4, 0.4 + np.pi], np.float32)
    _, rows = policy.respond(weights, None, jnp.asarray(seen), jnp.asarray(phase))
    for side in (0, 1):
        clock = [max(np.sin(phase[side]), 0.0), np.cos(phase[side])]
        inputs = np.concatenate([seen[side], clock])
        values = inputs
        for layer in (0, 1):
            sums = np.asarray(weights.weights[layer], np.float64) @ values
            if layer_norm:
                sums = weights.gains[layer] * (sums - sums.mean()) / np.sqrt(sums.var() + 1e-5)
            values = ACTIVATIONS[activation](sums + weights.biases[layer])
        asked = weights.weights[2] @ values + weights.biases[2] + weights.direct @ inputs
        np.testing.assert_allclose(rows[side], asked, atol=2e-5)  # float32 sums of some dozen
