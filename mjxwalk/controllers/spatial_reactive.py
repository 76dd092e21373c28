"""Linear reactive control in space: seven networks set desired angles from what the walker senses.

Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and 3D bipedal
walking over rough terrain", Adaptive Behavior 21(1), doi 10.1177/1059712312462904, sections 2.4,
2.5 and 3.5. Each network has 28 weights: 12 angles, 12 rates, double stance and a bias are its
inputs, stiffness and damping its gains. As in the plane, networks and inputs belong to roles
(stance, swing); roll and yaw change their sign with the stance foot, so that a mirrored walker
does the mirrored thing.
"""

import dataclasses
from collections.abc import Mapping
from typing import Literal, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from mjxwalk.controllers import tables
from mjxwalk.controllers.controller import Controller, Description
from mjxwalk.controllers.linear_reactive import Memory, stance_leg
from mjxwalk.envs import Action, SpatialObservation
from mjxwalk.envs.checks import positive
from mjxwalk.envs.edge import takes_genotype

NETWORKS = (
    "torso",
    "inter-leg",
    "stance knee",
    "swing knee",
    "stance ankle",
    "swing ankle",
    "adduction",
)
ANGLES = (
    "torso",
    "roll",
    "yaw",
    "stance thigh",
    "inter-leg",
    "stance knee",
    "swing knee",
    "stance ankle",
    "swing ankle",
    "adduction",
    "stance ankle roll",
    "swing ankle roll",
)
INPUTS = (*ANGLES, *(f"{angle} rate" for angle in ANGLES), "double stance", "bias")
OWN = np.array([ANGLES.index(network) for network in NETWORKS])

# ours: the paper's shifts and scales are lost; these bring the gaits that evolve to about -1 ... 1.
ANGLE_CENTRE = np.array([0, 0, 0, 0, 0, 0.2, 0.5, 0, 0, 0.05, 0, 0], np.float32)  # rad
ANGLE_SCALE = np.array(
    [0.3, 0.2, 0.5, 0.5, 0.6, 0.6, 0.6, 0.4, 0.4, 0.1, 0.3, 0.3], np.float32
)  # rad
RATE_SCALE = np.array([2, 1.5, 2, 3, 4, 8, 8, 4, 4, 1, 3, 3], np.float32)  # rad/s
LARGEST_INPUT = 3.0  # ours: what a stumble shows the networks stays bounded

# Of each network, all ours: the desired angle of an output of one, what it is cut to, and the gains
# that genes of zero stand for. Firm where the walker stands, soft where a leg swings.
TARGET_SCALE = np.array([0.3, 0.6, 0.6, 0.6, 0.4, 0.4, 0.1], np.float32)  # rad
TARGET_LOWEST = np.array([-0.6, -1.2, -0.5, -0.5, -0.6, -0.6, -0.1], np.float32)  # rad
TARGET_HIGHEST = np.array([0.6, 1.2, 1.2, 1.6, 0.6, 0.6, 0.3], np.float32)  # rad
STIFFNESS = np.array([100, 50, 100, 4, 16, 4, 200], np.float32)  # N m/rad
DAMPING = np.array([10, 4, 3, 0.1, 0.5, 0.1, 8], np.float32)  # N m s/rad

# Section 3.5.1: generation 0 has weights chosen by hand, which open the legs and lock the stance
# knee. ours: the numbers; also a swing knee that bends, a stance ankle that pushes off, a swing
# ankle that lifts the toes.
FIRST_BIASES = np.array([0.0, 0.8, -0.1, 0.7, -0.4, 0.3, 0.5], np.float32)

# Sections 2.5.3 and 2.7.3: spatial walkers have the links that pruning in the plane left, and the
# senses of balance for the adduction. ours: which ones those are in the plane.
SIL = {
    "torso": ("stance thigh", "inter-leg"),
    "inter-leg": ("torso", "stance thigh"),
    "stance ankle": ("torso", "stance thigh", "inter-leg"),
    "adduction": ("roll", "yaw", "stance ankle", "stance ankle roll"),
}
SIL_LINKS = {
    network: (*angles, *(f"{angle} rate" for angle in angles)) for network, angles in SIL.items()
}


class SpatialWeights(NamedTuple):
    """A genotype.

    Attributes:
      links: weight of each input, without unit.
      gains: logarithmic factors on stiffness and damping of each network.
    """

    links: Float[Array, "7 26"]
    gains: Float[Array, "7 2"]


class SpatialSenses(NamedTuple):
    """What the networks see, by role.

    Attributes:
      angle: in the order of ANGLES, rad.
      rate: rad/s.
      double_stance: whether both feet touch the ground.
    """

    angle: Float[Array, "12"]
    rate: Float[Array, "12"]
    double_stance: Bool[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class SpatialReactive(Controller):
    """Seven linear networks over twenty-six inputs, for legs that share their adduction.

    Attributes:
      links: "local" lets each network see its own angle, its rate and a bias only; "all" lets it
        see every input; a table lists the inputs that a network sees besides those three.
      swing_limit: torque at which the swing hip is cut, N m.
      stance_limit: likewise of the stance hip, N m.
    """

    # A table cannot be hashed; controllers that differ in it alone may share a hash.
    links: Literal["local", "all"] | Mapping[str, tuple[str, ...]] = dataclasses.field(
        default_factory=lambda: SIL_LINKS, hash=False
    )
    swing_limit: float = 60.0  # ours
    stance_limit: float = 80.0  # ours

    def __post_init__(self) -> None:
        tables.check(self.links, NETWORKS, INPUTS)
        positive(self, "swing_limit", "stance_limit")

    def template(self) -> SpatialWeights:
        """Returns the genotype that generation 0 is drawn around."""
        bias = INPUTS.index("bias")
        links = jnp.zeros((len(NETWORKS), len(INPUTS))).at[:, bias].set(FIRST_BIASES)
        return SpatialWeights(links, jnp.zeros((len(NETWORKS), 2)))

    def mask(self) -> SpatialWeights:
        """Returns which weights are there, in the shape of a genotype."""
        return SpatialWeights(jnp.asarray(self._links()), jnp.ones((len(NETWORKS), 2), bool))

    def prunable(self) -> SpatialWeights:
        """Returns the number of the link that each weight is, -1 where it must stay."""
        numbers = tables.numbered(self._links() & ~tables.mask("local", NETWORKS, INPUTS))
        return SpatialWeights(jnp.asarray(numbers), jnp.full((len(NETWORKS), 2), -1, jnp.int32))

    def networks(self) -> SpatialWeights:
        """Returns the number of the network that each weight belongs to."""
        rows = jnp.arange(len(NETWORKS))[:, None]
        wide = (len(NETWORKS), len(INPUTS))
        return SpatialWeights(
            jnp.broadcast_to(rows, wide), jnp.broadcast_to(rows, (len(NETWORKS), 2))
        )

    def weight_table(self, genotype: SpatialWeights) -> list[tuple[str, str, str, float]]:
        """Returns a genotype as rows of weight set, network, input and value; links only."""
        rows = tables.rows("walking", np.asarray(genotype.links), self._links(), NETWORKS, INPUTS)
        for place, gain in enumerate(("stiffness", "damping")):
            column = np.asarray(genotype.gains)[:, place]
            rows += [
                ("gains", network, gain, float(value))
                for network, value in zip(NETWORKS, column, strict=True)
            ]
        return rows

    @takes_genotype
    def init(self, weights: SpatialWeights) -> Memory:
        """Returns the memory at the start of a trial."""
        del weights
        return Memory(left_stance=jnp.zeros((), bool))

    @takes_genotype
    def act(
        self, weights: SpatialWeights, memory: Memory, observation: SpatialObservation
    ) -> tuple[Memory, Action]:
        """Returns the new memory and the seven motors' action.

        Knees, ankles and adduction are driven by their own angles, which the body may take
        implicitly; torso and inter-leg angle span several joints, so that the hips get plain
        torques. The stance hip gives what the torso needs beyond the swing hip's reaction.
        """
        left_stance = stance_leg(observation.contact, observation.ankle_x, memory.left_stance)
        senses = sense(observation, left_stance)
        outputs = jnp.where(self._links(), weights.links, 0.0) @ scaled_inputs(senses)
        target = jnp.clip(TARGET_SCALE * outputs, TARGET_LOWEST, TARGET_HIGHEST)
        stiffness = jnp.exp(weights.gains[:, 0]) * STIFFNESS
        damping = jnp.exp(weights.gains[:, 1]) * DAMPING
        drive = stiffness * (target - senses.angle[OWN]) - damping * senses.rate[OWN]
        swing_hip = jnp.clip(drive[1], -self.swing_limit, self.swing_limit)
        stance_hip = jnp.clip(drive[0] - swing_hip, -self.stance_limit, self.stance_limit)
        nothing = jnp.zeros(())

        def motors(values: Float[Array, "7"]) -> Float[Array, "7"]:
            """Puts values of the networks to the motors; the hips' come from the torques."""
            stance = jnp.stack([nothing, values[2], values[4]])
            swing = jnp.stack([nothing, values[3], values[5]])
            return _by_side(values[6], stance, swing, left_stance)

        zeros = jnp.zeros(2)
        torque = _by_side(
            nothing,
            jnp.concatenate([stance_hip[None], zeros]),
            jnp.concatenate([swing_hip[None], zeros]),
            left_stance,
        )
        action = Action(torque, motors(target), motors(stiffness), motors(damping))
        return Memory(left_stance), action

    def describe(self) -> Description:
        """Returns the scales of the inputs, and what each network's output becomes."""
        constants = {
            "target_scale": TARGET_SCALE,
            "target_lowest": TARGET_LOWEST,
            "target_highest": TARGET_HIGHEST,
            "stiffness": STIFFNESS,
            "damping": DAMPING,
        }
        inputs = tables.described_inputs(
            ANGLES, ANGLE_CENTRE, ANGLE_SCALE, RATE_SCALE, LARGEST_INPUT
        )
        return Description(inputs, tables.described_networks(NETWORKS, constants), tables.ROLES)

    def scaled(self, by: float) -> "SpatialReactive":
        """Returns the controller with its torques multiplied."""
        return dataclasses.replace(
            self, swing_limit=self.swing_limit * by, stance_limit=self.stance_limit * by
        )

    def _links(self) -> Bool[np.ndarray, "7 26"]:
        return tables.mask(self.links, NETWORKS, INPUTS)


def sense(observation: SpatialObservation, left_stance: Bool[Array, ""]) -> SpatialSenses:
    """Returns angles and rates by role.

    Thighs are measured from the vertical, forward positive. Roll is positive to the stance foot's
    side, yaw away from it.
    """

    if observation.adduction is None or observation.adduction_rate is None:
        raise ValueError(
            "the body has no adduction that both legs share, which this control senses"
        )

    def by_role(
        torso: Float[Array, "3"], adduction: Float[Array, ""], joints: Float[Array, "2 4"]
    ) -> Float[Array, "12"]:
        yaw, pitch, roll = torso
        side = jnp.where(left_stance, -1.0, 1.0)
        stance = jnp.where(left_stance, joints[0], joints[1])
        swing = jnp.where(left_stance, joints[1], joints[0])
        thigh, inter_leg = stance[0] - pitch, swing[0] - stance[0]
        legs = [thigh, inter_leg, stance[1], swing[1], stance[2], swing[2]]
        return jnp.stack([pitch, side * roll, side * yaw, *legs, adduction, stance[3], swing[3]])

    return SpatialSenses(
        by_role(observation.torso, observation.adduction, observation.angle),
        by_role(observation.torso_rate, observation.adduction_rate, observation.rate),
        observation.contact[0] & observation.contact[1],
    )


def scaled_inputs(senses: SpatialSenses) -> Float[Array, "26"]:
    """Returns the networks' inputs, each scaled to about -1 ... 1."""
    angle = (senses.angle - ANGLE_CENTRE) / ANGLE_SCALE
    scaled = jnp.concatenate([angle, senses.rate / RATE_SCALE])
    bounded = jnp.clip(scaled, -LARGEST_INPUT, LARGEST_INPUT)
    double_stance = senses.double_stance.astype(jnp.float32)
    return jnp.concatenate([bounded, jnp.stack([double_stance, jnp.ones(())])])


def _by_side(
    adduction: Float[Array, ""],
    stance: Float[Array, "3"],
    swing: Float[Array, "3"],
    left_stance: Bool[Array, ""],
) -> Float[Array, "7"]:
    """Returns the motors' order: adduction, then hip, knee and ankle, left and right."""
    left = jnp.where(left_stance, stance, swing)
    right = jnp.where(left_stance, swing, stance)
    return jnp.concatenate([adduction[None], left, right])
