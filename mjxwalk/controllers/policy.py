"""Policies for any body: what they share is the clock, the mirror, and how often they act.

Both sides share their weights: what the left leg does with what it feels, the right one does with
the same seen in a mirror, half a period later. So a gait is found once, not for each leg. Where no
sides are known, as in a task of an array of numbers, there is one policy for all.
"""

import abc
import dataclasses
from typing import Any, Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from mjxwalk.controllers import body_layout, layout, normalisation, wiring
from mjxwalk.controllers.controller import Controller, Description, Network, NetworkInput
from mjxwalk.controllers.layout import Layout
from mjxwalk.controllers.normalisation import Normalised, Statistics, Sums
from mjxwalk.controllers.wiring import Wiring
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
      sums: of what it has sensed; None of a policy that does not normalise its senses.
      time: since the start, s; None where the observation says it.
    """

    memory: Any
    action: Float[Array, " motor"]
    left: Int[Array, ""]
    sums: Sums | None = None
    time: Float[Array, ""] | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Policy(Controller):
    """A policy over an environment's senses, mirrored between sides where it has a body with sides.

    Attributes:
      moved: "legs" to move the legs' motors while the others hold where they start, or "all".
      rates: whether it feels how fast its joints move.
      period: from one action to the next, s; a task without a body has its own.
      clock: whether it sees a clock beside its senses; None for where it has a body.
      normalise: whether it sees its senses less their mean over their standard deviation, both of
        what populations have sensed since the start of the run.
      limit: of normalised senses, in standard deviations; more is cut off.
      layout: of the environment, which `on` fills in.
    """

    moved: Literal["legs", "all"] = "legs"
    rates: bool = False
    period: float = 0.02
    clock: bool | None = None
    normalise: bool = False
    limit: float = 5.0  # Salimans et al. (2017), in their code; Mania et al. (2018) cut nothing
    layout: Layout = Layout()

    def __post_init__(self) -> None:
        positive(self, "period", "limit")
        positive(self.layout, "time")
        if self.moved not in ("legs", "all"):
            raise ValueError(f'moved must be "legs" or "all", got "{self.moved}"')

    @abc.abstractmethod
    def weights(self) -> Any:
        """Returns the weights that generation 0 is drawn around: a pytree of arrays."""

    @abc.abstractmethod
    def respond(
        self,
        genotype: Any,
        memory: Any,
        seen: Float[Array, "side input"],
        phase: Float[Array, " side"],
        /,
    ) -> tuple[Any, Float[Array, "side row"]]:
        """Returns the new memory, and what each side's motors are asked for.

        Args:
          genotype: the weights.
          memory: of the last action.
          seen: scaled senses and, where there are sides, the same seen in a mirror.
          phase: of the clock, and half a period later, rad.
        """

    def present(self) -> Any:
        """Returns which weights are there, in their shape: all, but without a clock its pace."""
        every = jax.tree.map(lambda leaf: jnp.ones(jnp.shape(leaf), bool), self.weights())
        if self.sees_clock or not hasattr(every, "pace"):
            return every
        return every._replace(pace=jnp.zeros((), bool))

    def wiring(self) -> Wiring:
        """Returns what the weights connect; here nothing that could be pruned."""
        return Wiring(wiring.ends(self.describe()), ())

    def pace(self, genotype: Any, /) -> Float[Array, ""]:
        """Returns the gene of the clock's frequency; 0 of a policy that reads no clock."""
        return getattr(genotype, "pace", jnp.zeros(()))

    def recall(self, genotype: Any, /) -> Any:
        """Returns the memory at the start of a trial; nothing is remembered."""
        del genotype
        return None

    def on(self, env: Any) -> "Policy":
        """Returns the policy for an environment.

        Raises:
          ValueError: it has neither the body of a file nor named observations and actions.
        """
        if not hasattr(env, "anatomy"):
            return dataclasses.replace(self, layout=layout.of_task(env), period=env.timestep)
        found = body_layout.of_body(env, moved=self.moved, rates=self.rates, period=self.period)
        return dataclasses.replace(self, layout=found)

    def template(self) -> Any:
        """Returns the genotype that generation 0 is drawn around."""
        return self._beside(self.weights(), self.nothing_known())

    def mask(self) -> Any:
        """Returns which parts of a genotype strategies may change: the weights that are there."""
        return self._beside(self.present(), self._of_senses(False))

    def prunable(self) -> Any:
        """Returns the number of the link that each weight belongs to, -1 where it must stay."""
        links = wiring.number_links(self.wiring(), self.present())
        return self._beside(links, self._of_senses(-1))

    def networks(self) -> Any:
        """Returns the number of the layer that each weight belongs to."""
        layers = wiring.number_layers(self.wiring(), self.weights())
        return self._beside(layers, self._of_senses(0))

    def weight_table(self, genotype: Any) -> list[tuple[str, str, str, float]]:
        """Returns weights as rows of leaf, unit, unit or sense that it reads or "", and value."""
        return wiring.table(self.wiring(), self.weights_of(genotype), self.present())

    def weights_of(self, genotype: Any) -> Any:
        """Returns a genotype's weights, without what is known of the senses."""
        return genotype.weights if self.normalise else genotype

    def nothing_known(self) -> Statistics | None:
        """Returns what is known of the senses at first; None of a policy that needs no such."""
        return normalisation.nothing_known(len(self.layout.inputs)) if self.normalise else None

    def sensed(self, memory: Held, /) -> Sums | None:
        """Returns what was sensed in a trial, by its memory at the end."""
        sums = memory.sums
        if sums is None or self.layout.sides == 1:
            return sums
        # A body and its mirror image are one, so that both sides see alike.
        others = sums.squares[np.array(self.layout.input_mirror)]
        total = sums.total + self.layout.mirrored(sums.total)
        return Sums(2.0 * sums.num, total, sums.squares + others)

    def init(self, genotype: Any, /) -> Held:
        """Returns that nothing was asked for yet."""
        weights = self.weights_of(genotype)
        num = len(self.layout.inputs)
        return Held(
            self.recall(weights),
            jnp.zeros(self.layout.num_motors),
            jnp.zeros((), jnp.int32),
            normalisation.nothing_counted(num) if self.normalise else None,
            None if self.layout.timed else jnp.zeros(()),
        )

    def steps_held(self) -> int:
        """Returns for how many steps of the physics an action is asked for."""
        return self.layout.every

    def held(self, memory: Held, /) -> Held:
        """Returns the memory when the next action is due."""
        return memory._replace(left=jnp.zeros((), jnp.int32))

    @takes_genotype
    def act(
        self, genotype: Any, memory: Held, observation: Any
    ) -> tuple[Held, Float[Array, " motor"]]:
        """Returns the new memory, and a number from -1 to 1 for each motor."""
        fresh: Bool[Array, ""] = memory.left <= 0
        weights, sums, seen = genotype, memory.sums, self.layout.read(observation)
        if sums is not None:
            weights, senses = genotype
            away = seen - senses.mean
            sums = sums.add(away, fresh)
            seen = normalisation.normalise(senses, away, self.limit)
        time = observation.time if memory.time is None else memory.time
        after, asked = self.decide(weights, memory.memory, seen, time)
        if memory.time is not None:  # a task without a body is asked once a step
            return memory._replace(memory=after, sums=sums, time=time + self.period), asked
        after = jax.tree.map(lambda new, old: jnp.where(fresh, new, old), after, memory.memory)
        asked = jnp.where(fresh, asked, memory.action)
        left = jnp.where(fresh, self.layout.every, memory.left) - 1
        return Held(after, asked, left, sums), asked

    def decide(
        self, weights: Any, memory: Any, seen: Float[Array, " input"], time: Float[Array, ""]
    ) -> tuple[Any, Float[Array, " motor"]]:
        """Returns the new memory, and what is asked of each motor until the next action."""
        pace = PACE * (1.0 + PACE_RANGE * jnp.tanh(self.pace(weights))) / self.layout.time
        phase = 2.0 * jnp.pi * pace * time
        if self.layout.sides == 1:
            memory, (asked,) = self.respond(weights, memory, seen[None], phase[None])
            return memory, self.layout.action(jnp.clip(asked, -1.0, 1.0))
        memory, (ours, theirs) = self.respond(
            weights,
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
            roles=""
            if layout.sides == 1
            else (
                "outputs are cut to -1 ... 1; motors without a row have the output of their mirror "
                "partner's row for senses seen in a mirror and a clock half a period later, middle "
                "ones the mean of both; the clock's phase is 2 pi f time with f = "
                f"{PACE / layout.time:.6g} (1 + {PACE_RANGE:g} tanh(pace)) per second"
            ),
        )

    @property
    def rows(self) -> list[int]:
        """Places of the motors that have weights of their own: left and middle ones."""
        if self.layout.sides == 1:
            return list(range(len(self.layout.outputs)))
        mirror = self.layout.output_mirror
        return [place for place, other in enumerate(mirror) if place <= other]

    @property
    def sees_clock(self) -> bool:
        """Whether it sees a clock beside its senses."""
        return self.layout.timed if self.clock is None else self.clock

    @property
    def lift(self) -> list[float]:
        """How far each row moves its motor as its leg is lifted."""
        return [self.layout.lift[place] for place in self.rows]

    def _beside(self, weights: Any, senses: Any) -> Any:
        """Returns a genotype's tree of its weights and, where there are such, its senses."""
        return Normalised(weights, senses) if self.normalise else weights

    def _of_senses(self, value: Any) -> Statistics | None:
        """Returns a value for each number that is known of the senses."""
        known = self.nothing_known()
        return (
            None
            if known is None
            else jax.tree.map(lambda leaf: jnp.full_like(leaf, value, dtype=type(value)), known)
        )

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
