"""A multilayer perceptron for any body: senses and a clock, hidden layers, a number a motor."""

import dataclasses
import math
from typing import Any, Literal, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.controllers import clock
from mjxwalk.controllers.controller import Description
from mjxwalk.controllers.policy import Policy
from mjxwalk.controllers.wiring import Connection, Wiring, ends, units

ACTIVATIONS = {"tanh": jnp.tanh, "relu": jax.nn.relu, "elu": jax.nn.elu}
EPSILON = 1e-5  # added to a layer's variance, as is usual
OWN_KEY = 0  # of the first layers' weights, which are the same for every run; ours


class Layers(NamedTuple):
    """A genotype.

    Attributes:
      weights: of each layer [to, from].
      biases: of each layer.
      gains: of each hidden layer's units after its normalisation; None without that.
      direct: from senses and clock to the motors, past the layers.
      pace: gene of the clock's frequency.
    """

    weights: tuple[Float[Array, "to from"], ...]
    biases: tuple[Float[Array, " to"], ...]
    gains: tuple[Float[Array, " to"], ...] | None
    direct: Float[Array, "row input"]
    pace: Float[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Mlp(Policy):
    """A perceptron beside a linear policy, at first silent.

    Attributes:
      hidden: units of each layer.
      activation: of the hidden units.
      layer_norm: whether the sums of each hidden layer are brought to mean 0 and variance 1 before
        their gains and biases (Ba, Kiros & Hinton 2016).
    """

    hidden: tuple[int, ...] = (32, 32)
    activation: Literal["tanh", "relu", "elu"] = "tanh"
    layer_norm: bool = False

    def __post_init__(self) -> None:
        if not self.hidden or not all(0 < units <= 4096 for units in self.hidden):
            raise ValueError(
                f"hidden must be units from 1 to 4,096 a layer, got {list(self.hidden)}"
            )
        if self.activation not in ACTIVATIONS:
            known = ", ".join(ACTIVATIONS)
            raise ValueError(f'activation must be one of {known}, got "{self.activation}"')
        super().__post_init__()

    def weights(self) -> Layers:
        """Returns a walker that lifts its legs in turn; its last layer says nothing."""
        inputs = clock.num_inputs(self)
        sizes = (inputs, *self.hidden, len(self.rows))
        keys = jax.random.split(jax.random.key(OWN_KEY), len(sizes) - 1)
        weights = [
            jax.random.normal(key, (to, of)) / math.sqrt(of)
            for key, of, to in zip(keys, sizes[:-1], sizes[1:], strict=True)
        ]
        weights[-1] = jnp.zeros_like(weights[-1])
        return Layers(
            tuple(weights),
            tuple(jnp.zeros(to) for to in sizes[1:]),
            tuple(jnp.ones(to) for to in self.hidden) if self.layer_norm else None,
            clock.lifting(self),
            jnp.zeros(()),
        )

    def wiring(self) -> Wiring:
        """Returns each layer, which reads the one before it, and the motors, which read the senses
        too.
        """
        senses, motors = ends(self.describe())
        hidden = [units(f"hidden {k}", "unit", num) for k, num in enumerate(self.hidden, 1)]
        layers = senses, *hidden, motors
        names = [layer.name for layer in layers]
        pairs = list(zip(names[:-1], names[1:], strict=True))
        return Wiring(
            layers,
            (
                *(Connection(f"weights.{k}", *pair) for k, pair in enumerate(pairs)),
                Connection("direct", "senses", "motors"),
            ),
            {f"{part}.{k}": to for k, (_, to) in enumerate(pairs) for part in ("biases", "gains")},
        )

    def describe(self) -> Description:
        """Returns the columns of the first layer and of the direct weights, and the last rows."""
        return clock.described(self, super().describe())

    def respond(
        self,
        genotype: Layers,
        memory: Any,
        seen: Float[Array, "side input"],
        phase: Float[Array, " side"],
        /,
    ) -> tuple[Any, Float[Array, "side row"]]:
        """Returns no memory, and the last layer's sums with those of the direct weights."""
        seen = clock.inputs(self, seen, phase)
        values, activate = seen, ACTIVATIONS[self.activation]
        for layer, weights in enumerate(genotype.weights[:-1]):
            sums = values @ weights.T
            if genotype.gains is not None:
                sums = genotype.gains[layer] * _normalised(sums)
            values = activate(sums + genotype.biases[layer])
        last = values @ genotype.weights[-1].T + genotype.biases[-1]
        return memory, last + seen @ genotype.direct.T


def _normalised(sums: Float[Array, "side unit"]) -> Float[Array, "side unit"]:
    """Returns the sums of a layer with mean 0 and variance 1 over its units."""
    off = sums - jnp.mean(sums, axis=1, keepdims=True)
    return off / jnp.sqrt(jnp.mean(off**2, axis=1, keepdims=True) + EPSILON)
