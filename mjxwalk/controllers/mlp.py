"""A multilayer perceptron for any body: senses and a clock, layers of tanh, a number a motor."""

import dataclasses
import math
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.controllers.controller import Description
from mjxwalk.controllers.linear_feedback import CLOCK, described_with_clock, with_clock
from mjxwalk.controllers.policy import Policy

OWN_KEY = 0  # of the first layers' weights, which are the same for every run; ours


class Layers(NamedTuple):
    """A genotype.

    Attributes:
      weights: of each layer [to, from].
      biases: of each layer.
      direct: from senses and clock to the motors, past the layers.
      pace: gene of the clock's frequency.
    """

    weights: tuple[Float[Array, "to from"], ...]
    biases: tuple[Float[Array, " to"], ...]
    direct: Float[Array, "row input"]
    pace: Float[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Mlp(Policy):
    """A perceptron beside a linear policy, at first silent.

    Attributes:
      hidden: units of each layer.
    """

    hidden: tuple[int, ...] = (32, 32)

    def __post_init__(self) -> None:
        if not self.hidden or not all(0 < units <= 4096 for units in self.hidden):
            raise ValueError(f"hidden must be units from 1 to 4,096 a layer, got {self.hidden}")
        super().__post_init__()

    def template(self) -> Layers:
        """Returns a walker that lifts its legs in turn; its last layer says nothing."""
        inputs = len(self.layout.inputs) + len(CLOCK)
        sizes = (inputs, *self.hidden, len(self.rows))
        keys = jax.random.split(jax.random.key(OWN_KEY), len(sizes) - 1)
        weights = [
            jax.random.normal(key, (to, of)) / math.sqrt(of)
            for key, of, to in zip(keys, sizes[:-1], sizes[1:], strict=True)
        ]
        weights[-1] = jnp.zeros_like(weights[-1])
        direct = np.zeros((len(self.rows), inputs), np.float32)
        direct[:, -len(CLOCK)] = self.lift
        return Layers(
            tuple(weights),
            tuple(jnp.zeros(to) for to in sizes[1:]),
            jnp.asarray(direct),
            jnp.zeros(()),
        )

    def describe(self) -> Description:
        """Returns the columns of the first layer and of the direct weights, and the last rows."""
        return described_with_clock(super().describe())

    def respond(
        self,
        genotype: Layers,
        memory: Any,
        seen: Float[Array, "2 input"],
        phase: Float[Array, "2"],
        /,
    ) -> tuple[Any, Float[Array, "2 row"]]:
        """Returns no memory, and the last layer's sums with those of the direct weights."""
        inputs = with_clock(seen, phase)
        values = inputs
        for weights, bias in zip(genotype.weights[:-1], genotype.biases[:-1], strict=True):
            values = jnp.tanh(values @ weights.T + bias)
        last = values @ genotype.weights[-1].T + genotype.biases[-1]
        return memory, last + inputs @ genotype.direct.T
