"""Fitted Rayleigh oscillators that drive the planar walker's joints.

Ours: the thesis of `rayleigh` ends with curves. The oscillators of `patterns.HarmonicLegs`, fitted
to how adults walk, run on their own clock; hips and knees follow them by stiffness and damping, and
so do ankles, which the fit does not know, by weights that evolve from zero. Two senses are added.
Nothing else keeps a trunk upright: the stance hip pushes against the trunk's lean and its rate. And
a foot that lands can move the oscillators to where they are when a human's does, or nearer to it.
"""

import dataclasses
import functools
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import msgspec
import numpy as np
from jaxtyping import Array, Bool, Float

from mjxwalk import gaits
from mjxwalk.controllers.controller import Controller
from mjxwalk.controllers.linear_reactive import stance_leg
from mjxwalk.controllers.patterns import HarmonicGenes, HarmonicLegs, HarmonicNetwork
from mjxwalk.controllers.rayleigh import Motion
from mjxwalk.envs import Action, PlanarObservation
from mjxwalk.envs.checks import not_negative, positive
from mjxwalk.envs.edge import takes_genotype

# Written by scripts/ship_oscillators.py; says which command fitted them.
FITTED_PATH = Path(__file__).with_name("fitted_harmonics.json")
STIFFNESS = np.array([400.0, 300.0, 200.0], np.float32)  # N m/rad, hip, knee, ankle; ours
DAMPING = np.array([20.0, 15.0, 10.0], np.float32)  # N m s/rad; ours
POSTURE = np.array([400.0, 40.0], np.float32)  # N m/rad, N m s/rad at the stance hip; ours
RISE_TIME = 0.3  # s from standing to the full pattern; ours, its gene scales it


class Gains(NamedTuple):
    """A genotype; zero stands for the fitted pattern and the nominal gains.

    Attributes:
      tempo: logarithm of the factor on the oscillators' speed.
      rise: logarithm of the factor on `RISE_TIME`.
      amplitude: logarithms of the factors on the swing of hip and knee.
      offset: of the targets of hip, knee and ankle, rad.
      ankle: weights of each harmonic's angle and scaled rate in the ankle's target, rad.
      stiffness: logarithms of the factors on that of hip, knee and ankle.
      damping: logarithms of the factors on that of hip, knee and ankle.
      posture: logarithms of the factors on the stance hip's answer to lean and its rate.
      reset: share of the way to a human's heel strike that the oscillators jump at a landing; below
        0 counts as 0, above 1 as 1.
    """

    tempo: Float[Array, ""]
    rise: Float[Array, ""]
    amplitude: Float[Array, "2"]
    offset: Float[Array, "3"]
    ankle: Float[Array, "2 harmonic"]
    stiffness: Float[Array, "3"]
    damping: Float[Array, "3"]
    posture: Float[Array, "2"]
    reset: Float[Array, ""]


class Clock(NamedTuple):
    """Memory.

    Attributes:
      oscillators: where they were, [leg, harmonic].
      time: when, s.
      left_stance: which leg was the stance leg last.
      contact: which feet touched the ground.
    """

    oscillators: Motion
    time: Float[Array, ""]
    left_stance: Bool[Array, ""]
    contact: Bool[Array, "2"]


class Fitted(msgspec.Struct, frozen=True):
    """Oscillators as they were fitted.

    Attributes:
      command: that fitted them.
      genes: fields of `HarmonicGenes`.
      angle: settled, at the left heel's strike.
      rate: likewise, 1/s.
    """

    command: str
    genes: dict[str, Any]
    angle: list[list[float]]
    rate: list[list[float]]


@dataclasses.dataclass(frozen=True, kw_only=True)
class RayleighWalker(Controller):
    """Oscillators of human walking as a controller of a planar body with hips, knees and ankles.

    Attributes:
      posture: factor on the stance hip's answer to the trunk's lean; 0 leaves no sense at all.
      torque_limit: the posture's torque is cut there, N m.
    """

    posture: float = 1.0
    torque_limit: float = 300.0  # as the linear controller's

    def __post_init__(self) -> None:
        positive(self, "torque_limit")
        not_negative(self, "posture")

    def template(self) -> Gains:
        """Returns zeros."""
        harmonics = len(fitted().angle[0])
        zero = jnp.zeros(())
        three = jnp.zeros(3)
        return Gains(
            tempo=zero,
            rise=zero,
            amplitude=jnp.zeros(2),
            offset=three,
            ankle=jnp.zeros((2, harmonics)),
            stiffness=three,
            damping=three,
            posture=jnp.zeros(2),
            reset=zero,
        )

    @takes_genotype
    def init(self, genotype: Gains) -> Clock:
        """Returns the oscillators at the left heel's strike."""
        del genotype
        return Clock(_strike(left=True), jnp.zeros(()), jnp.ones((), bool), jnp.ones(2, bool))

    @takes_genotype
    def act(
        self, genotype: Gains, memory: Clock, observation: PlanarObservation
    ) -> tuple[Clock, Action]:
        """Returns the oscillators at the time of the observation, and what the joints are to do."""
        legs, network = _oscillators()
        left_stance = stance_leg(observation.contact, observation.ankle_x, memory.left_stance)
        # A clock that runs faster is the same motion in longer steps.
        own_step = (observation.time - memory.time) * jnp.exp(genotype.tempo)
        after = legs.step(network, memory.oscillators, own_step)
        oscillators = _landed(genotype, memory._replace(oscillators=after), observation)
        drawn = legs.read(network, oscillators)
        target = self._target(genotype, network, oscillators, drawn)
        rise = jnp.minimum(observation.time / (RISE_TIME * jnp.exp(genotype.rise)), 1.0)
        action = Action(
            torque=self._upright(genotype, observation, left_stance),
            target=(rise * target).reshape(6),
            stiffness=jnp.tile(STIFFNESS * jnp.exp(genotype.stiffness), 2),
            damping=jnp.tile(DAMPING * jnp.exp(genotype.damping), 2),
        )
        return Clock(oscillators, observation.time, left_stance, observation.contact), action

    def weight_table(self, genotype: Gains) -> list[tuple[str, str, str, float]]:
        """Returns a genotype as rows of kind, gene, place and value."""
        rows: list[tuple[str, str, str, float]] = []
        for name, leaf in zip(Gains._fields, genotype, strict=True):
            for place, value in np.ndenumerate(np.asarray(leaf)):
                rows.append(("gains", name, " ".join(map(str, place)), float(value)))
        return rows

    def _target(
        self, genotype: Gains, network: HarmonicNetwork, state: Motion, drawn: Motion
    ) -> Float[Array, "2 3"]:
        """Returns the targets of hip, knee and ankle of each leg, rad."""
        angle = jnp.deg2rad(drawn.angle).reshape(2, 2).T  # [leg, hip and knee]
        centre = jnp.deg2rad(network.genes.centre)
        swung = centre + jnp.exp(genotype.amplitude) * (angle - centre)
        cosine, sine = genotype.ankle
        ankle = jnp.sum(cosine * state.angle + sine * state.rate / network.mu, axis=1)
        return jnp.concatenate([swung, ankle[:, None]], axis=1) + genotype.offset

    def _upright(
        self, genotype: Gains, observation: PlanarObservation, left_stance: Bool[Array, ""]
    ) -> Float[Array, "6"]:
        """Returns the torque that rights the trunk, at the stance hip, N m."""
        stiffness, damping = self.posture * POSTURE * jnp.exp(genotype.posture)
        # A hip that extends pushes the trunk back: flexion is positive, as is leaning forward.
        righting = -stiffness * observation.pitch - damping * observation.pitch_rate
        torque = jnp.clip(righting, -self.torque_limit, self.torque_limit)
        on_left = jnp.where(left_stance, torque, 0.0)
        nothing = jnp.zeros(2)
        return jnp.concatenate([on_left[None], nothing, (torque - on_left)[None], nothing])


@functools.cache
def fitted() -> Fitted:
    """Returns the oscillators that ship with mjxwalk."""
    return msgspec.json.decode(FITTED_PATH.read_bytes(), type=Fitted)


def _strike(*, left: bool) -> Motion:
    """Returns the oscillators when a human's left or right heel strikes."""
    start = fitted()
    order = slice(None) if left else slice(None, None, -1)
    return Motion(jnp.array(start.angle)[order], jnp.array(start.rate)[order])


def _landed(genotype: Gains, memory: Clock, observation: PlanarObservation) -> Motion:
    """Returns the oscillators, moved towards a heel strike if the swing leg has just landed."""
    landed = observation.contact & ~memory.contact
    left = landed[0] & ~memory.left_stance
    right = landed[1] & memory.left_stance
    share = jnp.where(left | right, jnp.clip(genotype.reset, 0.0, 1.0), 0.0)
    return jax.tree.map(
        lambda now, one, other: now + share * (jnp.where(left, one, other) - now),
        memory.oscillators,
        _strike(left=True),
        _strike(left=False),
    )


def _oscillators() -> tuple[HarmonicLegs, HarmonicNetwork]:
    start = fitted()
    legs = HarmonicLegs(num_harmonics=len(start.angle[0]))
    genes = HarmonicGenes(**{name: jnp.array(value) for name, value in start.genes.items()})
    network, _ = legs.begin(genes, gaits.adults())
    return legs, network
