"""Linear feedback for any body: each motor's number is a weighted sum of senses and of a clock."""

import dataclasses
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.controllers.controller import Description, NetworkInput
from mjxwalk.controllers.policy import Policy

CLOCK = ("lift", "swing")  # the clock's inputs: a half sine while a leg is up, and a cosine


class FeedbackWeights(NamedTuple):
    """A genotype.

    Attributes:
      weights: of each motor's number, by senses, then the clock; left and middle motors.
      bias: of the same.
      pace: gene of the clock's frequency.
    """

    weights: Float[Array, "row input"]
    bias: Float[Array, " row"]
    pace: Float[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class LinearFeedback(Policy):
    """A linear policy; its settings are those of `Policy`."""

    def template(self) -> FeedbackWeights:
        """Returns weights of a walker that lifts its legs in turn and feels nothing."""
        return FeedbackWeights(lifting(self), jnp.zeros(len(self.rows)), jnp.zeros(()))

    def respond(
        self,
        genotype: FeedbackWeights,
        memory: Any,
        seen: Float[Array, "2 input"],
        phase: Float[Array, "2"],
        /,
    ) -> tuple[Any, Float[Array, "2 row"]]:
        """Returns no memory, and the weighted sums."""
        return memory, with_clock(seen, phase) @ genotype.weights.T + genotype.bias

    def describe(self) -> Description:
        """Returns the columns and the rows of the weights."""
        return described_with_clock(super().describe())


def lifting(policy: Policy) -> Float[Array, "row input"]:
    """Returns weights of senses and clock that lift a policy's legs in turn and feel nothing."""
    num = len(policy.layout.inputs)
    weights = np.zeros((len(policy.rows), num + len(CLOCK)), np.float32)
    weights[:, num] = policy.lift
    return jnp.asarray(weights)


def described_with_clock(description: Description) -> Description:
    """Returns a description with the clock's inputs after the others."""
    clock = (
        NetworkInput(name=name, unit="", centre=0.0, scale=1.0, limit=None)
        for name in ("clock's max(sin, 0)", "clock's cos")
    )
    return description._replace(inputs=(*description.inputs, *clock))


def with_clock(
    seen: Float[Array, "2 input"], phase: Float[Array, "2"]
) -> Float[Array, "2 input_and_clock"]:
    """Returns senses and the clock's inputs, for either side."""
    clock = [jnp.maximum(jnp.sin(phase), 0.0), jnp.cos(phase)]
    return jnp.concatenate([seen, jnp.stack(clock, axis=1)], axis=1)
