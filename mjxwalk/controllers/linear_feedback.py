"""Linear feedback for any body: each motor's number is a weighted sum of senses and of a clock.

Both sides share their weights: what the left leg does with what it feels, the right one does with
the same seen in a mirror, half a period later. So a gait is found once, not for each leg.
"""

import dataclasses
from typing import Any, Literal, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from mjxwalk.controllers import layout
from mjxwalk.controllers.controller import Controller
from mjxwalk.controllers.layout import Layout
from mjxwalk.envs import BodyObservation
from mjxwalk.envs.checks import positive
from mjxwalk.envs.edge import takes_genotype

CLOCK = ("lift", "swing")  # the clock's inputs: a half sine while a leg is up, and a cosine
PACE = 0.364  # steps of a leg a time of the body; ours: 1.2 a second of a body of 1 m
PACE_RANGE = 0.25  # by which the gene may change it, as a share; ours


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


class Held(NamedTuple):
    """What was asked for last, and for how many more steps it is.

    Attributes:
      action: numbers from -1 to 1, one for each motor.
      left: steps of the physics.
    """

    action: Float[Array, " motor"]
    left: Int[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class LinearFeedback(Controller):
    """A linear policy over a body's senses, mirrored between its sides.

    Attributes:
      moved: "legs" to move the legs' motors while the others hold where they start, or "all".
      rates: whether it feels how fast its joints move.
      period: from one action to the next, s.
      layout: of the body, which `on` fills in.
    """

    moved: Literal["legs", "all"] = "legs"
    rates: bool = False
    period: float = 0.02
    layout: Layout = Layout()

    def __post_init__(self) -> None:
        positive(self, "period")
        positive(self.layout, "time")

    def on(self, env: Any) -> "LinearFeedback":
        """Returns the controller for a body."""
        found = layout.of_body(env, moved=self.moved, rates=self.rates, period=self.period)
        return dataclasses.replace(self, layout=found)

    def template(self) -> FeedbackWeights:
        """Returns weights of a walker that lifts its legs in turn and feels nothing."""
        rows = self._rows
        weights = np.zeros((len(rows), len(self.layout.inputs) + len(CLOCK)), np.float32)
        weights[:, len(self.layout.inputs)] = np.array(self.layout.lift, np.float32)[rows]
        return FeedbackWeights(jnp.asarray(weights), jnp.zeros(len(rows)), jnp.zeros(()))

    def init(self, genotype: Any, /) -> Held:
        """Returns that nothing was asked for yet."""
        del genotype
        return Held(jnp.zeros(self.layout.num_motors), jnp.zeros((), jnp.int32))

    @takes_genotype
    def act(
        self, genotype: FeedbackWeights, memory: Held, observation: BodyObservation
    ) -> tuple[Held, Float[Array, " motor"]]:
        """Returns the new memory, and a number from -1 to 1 for each motor."""
        fresh: Bool[Array, ""] = memory.left <= 0
        asked = jnp.where(fresh, self.decide(genotype, observation), memory.action)
        left = jnp.where(fresh, self.layout.every, memory.left) - 1
        return Held(asked, left), asked

    def decide(
        self, genotype: FeedbackWeights, observation: BodyObservation
    ) -> Float[Array, " motor"]:
        """Returns what is asked of each motor until the next action."""
        seen = self.layout.read(observation)
        per_time = PACE * (1.0 + PACE_RANGE * jnp.tanh(genotype.pace)) / self.layout.time
        phase = 2.0 * jnp.pi * per_time * observation.time
        ours = self._outputs(genotype, seen, phase)
        theirs = self._outputs(genotype, self.layout.mirrored(seen), phase + jnp.pi)
        outputs: list[Array] = []
        rows = self._rows
        for place, mirror in enumerate(self.layout.output_mirror):
            sign = self.layout.output_sign[place]
            if mirror == place:
                row = rows.index(place)
                outputs.append(0.5 * (ours[row] + sign * theirs[row]))
            elif place in rows:
                outputs.append(ours[rows.index(place)])
            else:
                outputs.append(sign * theirs[rows.index(mirror)])
        return self.layout.action(jnp.stack(outputs))

    def _outputs(
        self, genotype: FeedbackWeights, seen: Float[Array, " input"], phase: Float[Array, ""]
    ) -> Float[Array, " row"]:
        clock = jnp.stack([jnp.maximum(jnp.sin(phase), 0.0), jnp.cos(phase)])
        inputs = jnp.concatenate([seen, clock])
        return jnp.clip(genotype.weights @ inputs + genotype.bias, -1.0, 1.0)

    @property
    def _rows(self) -> list[int]:
        """Places of the outputs that have weights of their own: the first of each pair."""
        mirror = self.layout.output_mirror
        return [place for place, other in enumerate(mirror) if place <= other]
