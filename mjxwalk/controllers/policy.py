"""Policies for any body: what they share is the clock, the mirror, and how often they act.

Both sides share their weights: what the left leg does with what it feels, the right one does with
the same seen in a mirror, half a period later. So a gait is found once, not for each leg.
"""

import abc
import dataclasses
from typing import Any, Literal, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from mjxwalk.controllers import layout
from mjxwalk.controllers.controller import Controller, Description, Network, NetworkInput
from mjxwalk.controllers.layout import Layout
from mjxwalk.envs.checks import positive
from mjxwalk.envs.edge import takes_genotype

UNITS = {"turning": "rad/s", "velocity": "m/s", "heading": "rad", "angle": "rad", "rate": "rad/s"}
PACE = 0.364  # steps of a leg a time of the body; ours: 1.2 a second of a body of 1 m
PACE_RANGE = 0.25  # by which the gene may change it, as a share; ours


class Held(NamedTuple):
    """What a policy remembers, and what was asked for last and for how many more steps it is.

    Attributes:
      memory: of the policy; None of one that remembers nothing.
      action: numbers from -1 to 1, one for each motor.
      left: steps of the physics.
    """

    memory: Any
    action: Float[Array, " motor"]
    left: Int[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Policy(Controller):
    """A policy over a body's senses, mirrored between its sides.

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
        if self.moved not in ("legs", "all"):
            raise ValueError(f'moved must be "legs" or "all", got "{self.moved}"')

    def pace(self, genotype: Any, /) -> Float[Array, ""]:
        """Returns the gene of the clock's frequency; 0 of a policy that reads no clock."""
        return getattr(genotype, "pace", jnp.zeros(()))

    @abc.abstractmethod
    def respond(
        self,
        genotype: Any,
        memory: Any,
        seen: Float[Array, "2 input"],
        phase: Float[Array, "2"],
        /,
    ) -> tuple[Any, Float[Array, "2 row"]]:
        """Returns the new memory, and what each side's motors are asked for.

        Args:
          genotype: the weights.
          memory: of the last action.
          seen: scaled senses, and the same seen in a mirror.
          phase: of the clock, and half a period later, rad.
        """

    def recall(self, genotype: Any, /) -> Any:
        """Returns the memory at the start of a trial; nothing is remembered."""
        del genotype
        return None

    def on(self, env: Any) -> "Policy":
        """Returns the policy for a body.

        Raises:
          ValueError: the environment has none that is given by a file.
        """
        found = layout.of_body(env, moved=self.moved, rates=self.rates, period=self.period)
        return dataclasses.replace(self, layout=found)

    def init(self, genotype: Any, /) -> Held:
        """Returns that nothing was asked for yet."""
        idle = jnp.zeros(self.layout.num_motors)
        return Held(self.recall(genotype), idle, jnp.zeros((), jnp.int32))

    @takes_genotype
    def act(
        self, genotype: Any, memory: Held, observation: Any
    ) -> tuple[Held, Float[Array, " motor"]]:
        """Returns the new memory, and a number from -1 to 1 for each motor."""
        fresh: Bool[Array, ""] = memory.left <= 0
        after, asked = self.decide(genotype, memory.memory, observation)
        after = jax.tree.map(lambda new, old: jnp.where(fresh, new, old), after, memory.memory)
        asked = jnp.where(fresh, asked, memory.action)
        left = jnp.where(fresh, self.layout.every, memory.left) - 1
        return Held(after, asked, left), asked

    def decide(
        self, genotype: Any, memory: Any, observation: Any
    ) -> tuple[Any, Float[Array, " motor"]]:
        """Returns the new memory, and what is asked of each motor until the next action."""
        seen = self.layout.read(observation)
        pace = PACE * (1.0 + PACE_RANGE * jnp.tanh(self.pace(genotype))) / self.layout.time
        phase = 2.0 * jnp.pi * pace * observation.time
        memory, (ours, theirs) = self.respond(
            genotype,
            memory,
            jnp.stack([seen, self.layout.mirrored(seen)]),
            jnp.stack([phase, phase + jnp.pi]),
        )
        return memory, self.layout.action(self._both_sides(ours, theirs))

    def describe(self) -> Description:
        """Returns the scaled senses, whose outputs the rows are, and what other motors get."""
        layout = self.layout
        seen = zip(layout.inputs, layout.centre, layout.scale, strict=True)
        return Description(
            inputs=tuple(
                NetworkInput(
                    name=name,
                    unit=UNITS.get(name.split()[0], ""),
                    centre=centre,
                    scale=scale,
                    limit=None,
                )
                for name, centre, scale in seen
            ),
            networks=tuple(Network(name=layout.outputs[row], constants={}) for row in self.rows),
            roles=(
                "outputs are cut to -1 ... 1; motors without a row have the output of their mirror "
                "partner's row for senses seen in a mirror and a clock half a period later, middle "
                "ones the mean of both; the clock's phase is 2 pi f time with f = "
                f"{PACE / layout.time:.6g} (1 + {PACE_RANGE:g} tanh(pace)) per second"
            ),
        )

    @property
    def rows(self) -> list[int]:
        """Places of the motors that have weights of their own: left and middle ones."""
        mirror = self.layout.output_mirror
        return [place for place, other in enumerate(mirror) if place <= other]

    @property
    def lift(self) -> list[float]:
        """How far each row moves its motor as its leg is lifted."""
        return [self.layout.lift[place] for place in self.rows]

    def _both_sides(
        self, ours: Float[Array, " row"], theirs: Float[Array, " row"]
    ) -> Float[Array, " output"]:
        """Returns what all motors are asked for: middle ones by both sides together."""
        rows = self.rows
        outputs: list[Array] = []
        for place, mirror in enumerate(self.layout.output_mirror):
            sign = self.layout.output_sign[place]
            if mirror == place:
                row = rows.index(place)
                outputs.append(0.5 * (ours[row] + sign * theirs[row]))
            elif place in rows:
                outputs.append(ours[rows.index(place)])
            else:
                outputs.append(sign * theirs[rows.index(mirror)])
        return jnp.clip(jnp.stack(outputs), -1.0, 1.0)
