"""What moves the biped of Reil & Massey: motors, knee caps, springs, assistance, and a load.

Source as in `reil.py`.
"""

import dataclasses
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import checks, dynamics, floating, motor
from mjxwalk.envs.anatomy import Anatomy
from mjxwalk.envs.bodies import reil_body
from mjxwalk.envs.bodies.reil_body import EULER, HIPS, NUM_COORDINATES, Offsets
from mjxwalk.envs.bodies.reil_state import HipTargets
from mjxwalk.envs.bodies.reil_trials import TrialVariation
from mjxwalk.envs.contact import SoftContact
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.legged import Driven, LeggedEnv
from mjxwalk.envs.legged_body import Sprung
from mjxwalk.envs.state import State
from mjxwalk.envs.trees import GRAVITY, Instant, Loads
from mjxwalk.envs.trial import Trial
from mjxwalk.envs.velocity_motor import VelocityMotor


@dataclasses.dataclass(frozen=True, kw_only=True)
class ReilPhysics(LeggedEnv):
    """The body and the forces on it.

    The paper gives sizes, densities and the kinds of joints; all other numbers are ours, and
    docs/reil.md tells how much depends on each. The implicit integrator is stable at 2 ms; motors
    are always those of the end of the step.

    Attributes:
      terrain: flat ground, and how trials differ.
      hips: motor of either hip's pitch.
      hip_offset: from the midline to either hip, m.
      trunk_height: of the trunk's centre over the hips, m.
      heel: of the heel's sphere ahead of the ankle, m; negative is behind.
      toe: of the toe's sphere ahead of the ankle, m.
      sole: of both spheres' centres below the ankle, m.
      hip_roll_stiffness: of the spring that holds the legs beside each other, N m/rad.
      hip_roll_damping: N m s/rad.
      knee_cap: law of the knee's stops.
      knee_extension: where the knee cap stops it, rad; negative is bent backwards.
      knee_flexion: where calf meets thigh, rad.
      knee_damping: of the knee between its stops, N m s/rad.
      ankle_stiffness: N m/rad.
      ankle_damping: N m s/rad.
      ankle_rest: where the ankle's spring is slack, rad, toes up positive.
      assistance: stiffness of the assisting controller that rights the trunk, N m/rad.
      assistance_damping: of that controller, N m s/rad.
      assistance_lean: that it holds the trunk at, rad, forward positive.
      assistance_roll: share of both that acts sideways.
    """

    terrain: TrialVariation = TrialVariation()
    contact: SoftContact = SoftContact(stiffness=150_000.0, damping=6_000.0)  # ours
    # ours: nearly rigid; this softness is a damper of some 3,000 N m s/rad
    hips: VelocityMotor = VelocityMotor(
        approach=21.4, max_speed=2.89, max_torque=2_240.0, softness=0.00032
    )
    hip_offset: float = 0.125  # ours: the hips' spheres touch
    trunk_height: float = 0.3  # ours: the trunk begins at the hips
    heel: float = -0.079  # ours: the foot is short and lies behind
    toe: float = -0.029  # ours
    sole: float = 0.04  # ours
    hip_roll_stiffness: float = 20_000.0  # ours: held, as no motor neuron drives it
    hip_roll_damping: float = 1_000.0  # ours
    knee_cap: JointStop = JointStop(stiffness=1_650.0, damping=112.0)  # ours
    knee_extension: float = -0.069  # ours: a straight knee gives way under load
    knee_flexion: float = 2.0  # ours
    knee_damping: float = 128.0  # ours: far too much to swing freely; with less few walk
    ankle_stiffness: float = 1_340.0  # ours
    ankle_damping: float = 114.0  # ours
    ankle_rest: float = 0.42  # ours: it lets the calf lean forward over the foot
    assistance: float = 0.0
    assistance_damping: float = 0.0
    assistance_lean: float = 0.0
    assistance_roll: float = 1.0
    timestep: float = 0.002  # ours: the paper gives none

    def __post_init__(self) -> None:
        checks.positive(self, "hip_offset", "knee_flexion")
        checks.not_negative(self, "hip_roll_stiffness", "hip_roll_damping", "knee_damping")
        checks.not_negative(self, "ankle_stiffness", "ankle_damping", "sole")
        checks.not_negative(self, "assistance", "assistance_damping", "assistance_roll")
        if not self.toe > self.heel:
            raise ValueError(f"toe must be ahead of heel, {self.heel} m, got {self.toe}")
        if not self.knee_extension < self.knee_flexion:
            raise ValueError(
                f"knee_extension must be below knee_flexion, {self.knee_flexion} rad, "
                f"got {self.knee_extension}"
            )
        if self.payload:
            raise ValueError(
                "payload must be none, as this body carries terrain.load in its trunk, got "
                f"share {self.payload.share}"
            )
        super().__post_init__()

    @property
    def offsets(self) -> Offsets:
        """Where parts are joined."""
        return Offsets(self.hip_offset, self.trunk_height, self.heel, self.toe, self.sole)

    @property
    def model(self) -> dynamics.Model:
        return reil_body.hinged_model(self.offsets)

    @property
    def floating(self) -> dynamics.Model:
        return reil_body.floating_model(self.offsets)

    @property
    def anatomy(self) -> Anatomy:
        knee = self.knee_extension, self.knee_flexion
        return reil_body.anatomy(self.offsets, knee, self.hips.max_torque)

    def spec(self) -> Any:
        return reil_body.whole_spec(self.offsets, self.springs, self.hips.max_torque)

    @property
    def stop_law(self) -> JointStop:
        return self.knee_cap

    @property
    def springs(self) -> Sprung:
        """Springs and dampers of hip roll, knee and ankle of each leg."""
        rest = [0.0, 0.0, self.ankle_rest]
        stiffness = [self.hip_roll_stiffness, 0.0, self.ankle_stiffness]
        damping = [self.hip_roll_damping, self.knee_damping, self.ankle_damping]
        columns = (np.array(part * 2, np.float32) for part in (stiffness, rest, damping))
        return Sprung(np.array([0, 2, 3, 4, 6, 7], np.int32), motor.Springs(*columns))

    def scaled_action(self, values: Float[Array, " motor"], /) -> HipTargets:
        """Returns desired angles of numbers from -1 to 1, one for each hip."""
        left, _ = self.anatomy.motors
        return HipTargets(left.centre + left.strength * jnp.clip(values, -1.0, 1.0))

    def carried(self, state: State, now: Instant, given: Trial, /) -> Loads:
        """Returns what the trunk carries: weight, inertia, and what holds it on its curve."""
        if not self.terrain.load or given.load is None or now.axes is None:
            return {}
        mass = self.terrain.load * given.load
        offset = jnp.array([0.0, 0.0, self.trunk_height])
        spin = floating.spin(state.qpos[EULER], state.qvel[EULER])
        curving = jnp.cross(spin, jnp.cross(spin, offset))
        force = -mass * (GRAVITY * now.axes[2] + curving)
        torso = self.floating.mujoco.body("torso").id
        return {torso: [dynamics.PointLoad(offset, force, mass)]}

    def drive(self, state: State, action: HipTargets, now: Instant, loads: Loads) -> Driven:
        """Returns what motors, springs and stops do to the body.

        The motors' torques are solved for with the accelerations that they bring.
        """
        torque, inertia = self.passive(state)
        righting, resistance = self._assistance(state, now)
        # The trunk's translation comes first, then its rotation about its own axes.
        force = jnp.concatenate([jnp.zeros(3), righting, torque])
        added = jnp.concatenate([jnp.zeros(3), resistance, inertia])
        matrix, right = self._tree.equations(now, force, added, loads)
        coasting = dynamics.solve(matrix, right)
        answer = jnp.stack([dynamics.solve(matrix, one) for one in jnp.eye(NUM_COORDINATES)[HIPS]])
        angle, rate = state.qpos[HIPS], state.qvel[HIPS]
        wanted = self.hips.request(action.target, angle) - rate - self.timestep * coasting[HIPS]
        torque = self.hips.torques(self.timestep * answer[:, HIPS], wanted)
        return Driven(coasting + torque @ answer, lambda qvel: torque)

    def motor_torques(
        self, state: State, action: HipTargets, given: Trial
    ) -> Float[Array, " motor"]:
        """Returns the torques of the hips' motors in the step that follows, N m."""
        now, _, loads = self._seen(state, given)
        return self.drive(state, action, now, loads).torque(state.qvel)

    def _assistance(
        self, state: State, now: Instant
    ) -> tuple[Float[Array, "3"], Float[Array, "3"]]:
        """Returns the torque that rights the trunk about its own axes, and its implicit part.

        It turns the trunk's vertical towards the world's, or towards one that leans; yaw is free.
        """
        if now.axes is None or not (self.assistance or self.assistance_damping):
            return jnp.zeros(3), jnp.zeros(3)
        damping = self.assistance_damping + self.lookahead * self.assistance
        spin = floating.spin(state.qpos[EULER], state.qvel[EULER])
        forward, left, _ = now.axes[2]
        off = jnp.stack([-left, forward + jnp.sin(self.assistance_lean), jnp.zeros(())])
        tilting = jnp.array([self.assistance_roll, 1.0, 0.0])
        righting = (self.assistance * off - damping * spin) * tilting
        return righting, tilting * self.lookahead * damping
