"""Linear feedback for any body: each motor's number is a weighted sum of senses and of a clock."""

import dataclasses
from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.controllers import clock
from mjxwalk.controllers.controller import Description
from mjxwalk.controllers.policy import Policy
from mjxwalk.controllers.wiring import Connection, Wiring, ends


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

    def weights(self) -> FeedbackWeights:
        """Returns weights of a walker that lifts its legs in turn and feels nothing."""
        return FeedbackWeights(clock.lifting(self), jnp.zeros(len(self.rows)), jnp.zeros(()))

    def respond(
        self,
        genotype: FeedbackWeights,
        memory: Any,
        seen: Float[Array, "side input"],
        phase: Float[Array, " side"],
        /,
    ) -> tuple[Any, Float[Array, "side row"]]:
        """Returns no memory, and the weighted sums."""
        return memory, clock.inputs(self, seen, phase) @ genotype.weights.T + genotype.bias

    def steps_held(self) -> int:
        """Returns 1: to weigh its inputs anew costs less than a loop that holds what they gave."""
        return 1

    def steps_per_action(self) -> int:
        """Returns for how many steps of the physics an action stays the same."""
        return self.layout.every

    def wiring(self) -> Wiring:
        """Returns the motors, which read the senses and the clock."""
        return Wiring(ends(self.describe()), (Connection("weights", "senses", "motors"),))

    def describe(self) -> Description:
        """Returns the columns and the rows of the weights."""
        return clock.described(self, super().describe())
