"""Linear reactive control: every joint's drive is a weighted sum of the walker's senses.

Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and 3D bipedal
walking over rough terrain", Adaptive Behavior 21(1), sections 2.4 to 2.6 and Appendix B. Networks
and inputs belong to roles (stance, swing), not to sides.
"""

import dataclasses
from collections.abc import Mapping
from typing import Literal, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from mjxwalk.controllers import tables
from mjxwalk.controllers.controller import Controller, Description
from mjxwalk.envs import Action, PlanarObservation
from mjxwalk.envs.checks import not_negative, positive
from mjxwalk.envs.edge import takes_genotype

NETWORKS = ("torso", "inter-leg", "stance knee", "swing knee", "stance ankle", "swing ankle")
ANGLES = (
    "torso",
    "stance thigh",
    "inter-leg",
    "stance knee",
    "swing knee",
    "stance ankle",
    "swing ankle",
)
INPUTS = (*ANGLES, *(f"{angle} rate" for angle in ANGLES), "double stance", "bias")

# ours: the paper's shifts and scales are lost; these bring the gaits that evolve to about -1 ... 1.
ANGLE_CENTRE = np.array([0.0, 0.0, 0.0, 0.2, 0.5, 0.0, 0.0], np.float32)  # rad
ANGLE_SCALE = np.array([0.3, 0.4, 0.6, 0.6, 0.6, 0.4, 0.4], np.float32)  # rad
RATE_SCALE = np.array([2.0, 3.0, 4.0, 8.0, 8.0, 4.0, 4.0], np.float32)  # rad/s
SHORTEST_BLEND = 0.2  # s; ours: keeps the blend time's gene away from a division by zero

# Nominal drive of the desired-angle output, for each network; its genes scale the gains.
TARGET_SCALE = ANGLE_SCALE[[0, 2, 3, 4, 5, 6]]  # rad; ours: as wide as the sensors' range
TARGET_CENTRE = ANGLE_CENTRE[[0, 2, 3, 4, 5, 6]]  # rad; ours
STIFFNESS = np.array([400.0, 200.0, 400.0, 40.0, 400.0, 40.0], np.float32)  # N m/rad; ours
DAMPING = np.array([40.0, 20.0, 20.0, 4.0, 20.0, 4.0], np.float32)  # N m s/rad; ours


class Weights(NamedTuple):
    """A genotype.

    Attributes:
      initiation: weights at the start of a trial, without unit.
      walking: weights after the gait has been initiated, without unit.
      blend_time: gene of the time in which the one turns into the other, s.
      gains: logarithmic factors on stiffness and damping of each network; None for torque output.
    """

    initiation: Float[Array, "6 16"]
    walking: Float[Array, "6 16"]
    blend_time: Float[Array, ""]
    gains: Float[Array, "6 2"] | None


class Memory(NamedTuple):
    """Which leg was the stance leg last; kept while neither foot touches the ground."""

    left_stance: Bool[Array, ""]


class Senses(NamedTuple):
    """What the networks see, by role.

    Attributes:
      angle: the seven angles in the order of ANGLES, rad.
      rate: rad/s.
      double_stance: whether both feet touch the ground.
    """

    angle: Float[Array, "7"]
    rate: Float[Array, "7"]
    double_stance: Bool[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class LinearReactive(Controller):
    """Six linear networks over sixteen inputs.

    Attributes:
      links: "local" lets each network see its own angle, its rate and a bias only (LPD, 18
        weights); "all" lets it see every input (FIL, 96 weights); a table lists the inputs that a
        network sees besides those three (RSIL), none where it does not name the network.
      output: "torque" makes the output the joint's torque, as in the plane; "angle" makes it a
        desired angle with stiffness and damping as genes, as in space.
      torque_scale: torque for an output of one, N m.
      torque_limit: a joint's torque is cut there, N m.
    """

    # A table cannot be hashed; controllers that differ in it alone may share a hash.
    links: Literal["local", "all"] | Mapping[str, tuple[str, ...]] = dataclasses.field(
        default="local", hash=False
    )
    output: Literal["torque", "angle"] = "torque"
    torque_scale: float = 100.0  # ours: makes the paper's mutation sizes meaningful
    torque_limit: float = 300.0  # ours: the paper names none; a strong human's knee

    def __post_init__(self) -> None:
        tables.check(self.links, NETWORKS, INPUTS)
        if self.output not in ("torque", "angle"):
            raise ValueError(f"output must be one of torque, angle, got {self.output!r}")
        positive(self, "torque_limit")
        not_negative(self, "torque_scale")

    def template(self) -> Weights:
        """Returns a genotype of zeros, with the blend time in the middle of its range."""
        zeros = jnp.zeros((len(NETWORKS), len(INPUTS)))
        gains = jnp.zeros((len(NETWORKS), 2)) if self.output == "angle" else None
        return Weights(zeros, zeros, jnp.asarray(0.5), gains)

    def mask(self) -> Weights:
        """Returns which weights are links, in the shape of a genotype."""
        links = jnp.asarray(self._links())
        gains = jnp.ones((len(NETWORKS), 2), bool) if self.output == "angle" else None
        return Weights(links, links, jnp.ones((), bool), gains)

    def prunable(self) -> Weights:
        """Returns the number of the link that each weight belongs to, -1 where it must stay.

        A link is a network's view of one input, at the start of a trial and later. Its own angle,
        own rate and bias must stay, and what is no link: blend time and gains.
        """
        links = jnp.asarray(tables.numbered(self._links() & ~local_links()))
        gains = jnp.full((len(NETWORKS), 2), -1, jnp.int32) if self.output == "angle" else None
        return Weights(links, links, jnp.asarray(-1, jnp.int32), gains)

    def networks(self) -> Weights:
        """Returns the number of the network each weight belongs to; the blend time is the last."""
        numbers = jnp.arange(len(NETWORKS))[:, None]
        rows = jnp.broadcast_to(numbers, (len(NETWORKS), len(INPUTS)))
        gains = jnp.broadcast_to(numbers, (len(NETWORKS), 2)) if self.output == "angle" else None
        return Weights(rows, rows, jnp.asarray(len(NETWORKS)), gains)

    @takes_genotype
    def init(self, weights: Weights) -> Memory:
        """Returns the memory at the start of a trial."""
        del weights
        return Memory(left_stance=jnp.zeros((), bool))

    @takes_genotype
    def act(
        self, weights: Weights, memory: Memory, observation: PlanarObservation
    ) -> tuple[Memory, Action]:
        """Returns the new memory and the six joints' action."""
        left_stance = stance_leg(observation.contact, observation.ankle_x, memory.left_stance)
        senses = sense(observation, left_stance)
        outputs = self._blended(weights, observation.time) @ scaled_inputs(senses)
        if self.output == "torque":
            by_role = self._torques(outputs)
        else:
            by_role = self._desired_angles(weights, outputs, senses)
        by_side = Action(*(_by_side(joints, left_stance) for joints in by_role))
        return Memory(left_stance), by_side

    def weight_table(self, genotype: Weights) -> list[tuple[str, str, str, float]]:
        """Returns a genotype as rows of weight set, network, input and value; links only."""
        sets = [("initiation", genotype.initiation), ("walking", genotype.walking)]
        return [
            row
            for name, weights in sets
            for row in tables.rows(name, np.asarray(weights), self._links(), NETWORKS, INPUTS)
        ]

    def describe(self) -> Description:
        """Returns the scales of the inputs, and what each network's output becomes."""
        if self.output == "torque":
            constants = {"torque_scale": np.full(len(NETWORKS), self.torque_scale, np.float32)}
        else:
            constants = {
                "target_centre": TARGET_CENTRE,
                "target_scale": TARGET_SCALE,
                "stiffness": STIFFNESS,
                "damping": DAMPING,
            }
        inputs = tables.described_inputs(ANGLES, ANGLE_CENTRE, ANGLE_SCALE, RATE_SCALE)
        return Description(inputs, tables.described_networks(NETWORKS, constants), tables.ROLES)

    def scaled(self, by: float) -> "LinearReactive":
        """Returns the controller with its torques multiplied."""
        return dataclasses.replace(
            self, torque_scale=self.torque_scale * by, torque_limit=self.torque_limit * by
        )

    def _links(self) -> Bool[np.ndarray, "6 16"]:
        return tables.mask(self.links, NETWORKS, INPUTS)

    def _blended(self, weights: Weights, time: Float[Array, ""]) -> Float[Array, "6 16"]:
        """Returns the weights at a time: they move linearly from initiation to walking."""
        blend = jnp.minimum(time / (SHORTEST_BLEND + jnp.abs(weights.blend_time)), 1.0)
        mixed = weights.initiation + (weights.walking - weights.initiation) * blend
        return jnp.where(self._links(), mixed, 0.0)

    def _torques(self, outputs: Float[Array, "6"]) -> Action:
        """Returns the action, by role, of networks whose outputs are torques."""
        torso, inter_leg, *limbs = self._clip(self.torque_scale * outputs)
        # The stance hip gives what the torso needs beyond the swing hip's reaction (Appendix B).
        stance_knee, swing_knee, stance_ankle, swing_ankle = limbs
        torque = jnp.stack(
            [torso - inter_leg, stance_knee, stance_ankle, inter_leg, swing_knee, swing_ankle]
        )
        nothing = jnp.zeros(6)
        return Action(torque, nothing, nothing, nothing)

    def _desired_angles(
        self, weights: Weights, outputs: Float[Array, "6"], senses: Senses
    ) -> Action:
        """Returns the action, by role, of networks whose outputs are desired angles.

        Knees and ankles are driven by their own angles, which the body may take implicitly; torso
        and inter-leg angle span several joints, so that the hips get plain torques.
        """
        assert weights.gains is not None  # for the type checker: template() sets them
        stiffness = jnp.exp(weights.gains[:, 0]) * STIFFNESS
        damping = jnp.exp(weights.gains[:, 1]) * DAMPING
        target = outputs * TARGET_SCALE + TARGET_CENTRE
        own = np.array([0, 2, 3, 4, 5, 6])
        drive = stiffness * (target - senses.angle[own]) - damping * senses.rate[own]
        torso, inter_leg = self._clip(drive[0]), self._clip(drive[1])
        nothing = jnp.zeros(())

        def joints(values: Float[Array, "6"]) -> Float[Array, "6"]:
            return jnp.stack([nothing, values[2], values[4], nothing, values[3], values[5]])

        still = [nothing, nothing]
        torque = jnp.stack([torso - inter_leg, *still, inter_leg, *still])
        return Action(torque, joints(target), joints(stiffness), joints(damping))

    def _clip(self, torque: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
        return jnp.clip(torque, -self.torque_limit, self.torque_limit)


def local_links() -> Bool[np.ndarray, "6 16"]:
    """Returns the links of LPD: each network's own angle, own rate and bias, [network, input]."""
    return tables.mask("local", NETWORKS, INPUTS)


def stance_leg(
    contact: Bool[Array, "2"], ankle_x: Float[Array, "2"], before: Bool[Array, ""]
) -> Bool[Array, ""]:
    """Returns whether the left leg is the stance leg (section 2.4).

    The leg on the ground is; of two, the trailing one, which so keeps its push-off; in flight, the
    one that was.
    """
    left, right = contact[0], contact[1]
    trailing = ankle_x[0] < ankle_x[1]
    return jnp.where(left & right, trailing, jnp.where(left | right, left, before))


def sense(observation: PlanarObservation, left_stance: Bool[Array, ""]) -> Senses:
    """Returns angles and rates by role; thighs are measured from the vertical, forward positive."""
    angle, rate = observation.angle, observation.rate

    def by_role(pitch: Float[Array, ""], joints: Float[Array, "2 3"]) -> Float[Array, "7"]:
        stance = jnp.where(left_stance, joints[0], joints[1])
        swing = jnp.where(left_stance, joints[1], joints[0])
        thigh, inter_leg = stance[0] - pitch, swing[0] - stance[0]
        return jnp.stack([pitch, thigh, inter_leg, stance[1], swing[1], stance[2], swing[2]])

    return Senses(
        by_role(observation.pitch, angle),
        by_role(observation.pitch_rate, rate),
        observation.contact[0] & observation.contact[1],
    )


def scaled_inputs(senses: Senses) -> Float[Array, "16"]:
    """Returns the networks' inputs, each scaled to about -1 ... 1."""
    angle = (senses.angle - ANGLE_CENTRE) / ANGLE_SCALE
    rate = senses.rate / RATE_SCALE
    double_stance = senses.double_stance.astype(jnp.float32)
    return jnp.concatenate([angle, rate, jnp.stack([double_stance, jnp.ones(())])])


def _by_side(by_role: Float[Array, "6"], left_stance: Bool[Array, ""]) -> Float[Array, "6"]:
    """Turns stance leg, swing leg into left leg, right leg."""
    stance, swing = by_role[:3], by_role[3:]
    left = jnp.where(left_stance, stance, swing)
    right = jnp.where(left_stance, swing, stance)
    return jnp.concatenate([left, right])
