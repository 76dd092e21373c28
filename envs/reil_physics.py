"""What moves the biped of Reil & Massey: ground, motors, knee caps, springs, assistance.

Source as in `reil.py`.
"""

import dataclasses
import operator
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import checks, dynamics, floating, motor
from mjxwalk.envs.contact import ContactForce, SoftContact
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.reil_body import (
    EULER,
    FEET,
    GRAVITY,
    HIPS,
    JOINTS,
    KNEES,
    NUM_COORDINATES,
    SPHERE_RADIUS,
    Offsets,
    floating_model,
    hinged_model,
)
from mjxwalk.envs.reil_state import HipTargets, State
from mjxwalk.envs.reil_trials import TrialVariation
from mjxwalk.envs.terrain import Terrain
from mjxwalk.envs.velocity_motor import VelocityMotor


@dataclasses.dataclass(frozen=True, kw_only=True)
class ReilPhysics:
    """The body, its ground, and the forces on it.

    Attributes:
      terrain: flat ground, and how trials differ.
      contact: law of the ground at each sphere.
      hips: motor of either hip's pitch.
      hip_offset: from the midline to either hip, m.
      trunk_height: of the trunk's centre over the hips, m.
      heel: of the heel's sphere ahead of the ankle, m; negative is behind.
      toe: likewise.
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
      assistance_damping: likewise, N m s/rad.
      assistance_lean: that it holds the trunk at, rad, forward positive.
      assistance_roll: share of both that acts sideways.
      timestep: of the physics, s.
      integrator: "implicit" takes contact, stops, springs and dampers at the end of the step, which
        is stable at 2 ms; "explicit" at its start. Motors are always those of the end of the step.
        Positions follow the new velocities (semi-implicit Euler).
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
    integrator: Literal["implicit", "explicit"] = "implicit"

    def __post_init__(self) -> None:
        checks.positive(self, "timestep", "hip_offset", "knee_flexion")
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
        if self.integrator not in ("implicit", "explicit"):
            raise ValueError(
                f'integrator must be "implicit" or "explicit", got "{self.integrator}"'
            )

    @property
    def offsets(self) -> Offsets:
        """Where parts are joined."""
        return Offsets(self.hip_offset, self.trunk_height, self.heel, self.toe, self.sole)

    @property
    def model(self) -> dynamics.Model:
        """The compiled body."""
        return hinged_model(self.offsets)

    @property
    def floating(self) -> dynamics.Model:
        """The same with a free root, as `mjxwalk.envs.floating` takes it."""
        return floating_model(self.offsets)

    @property
    def weight(self) -> float:
        """Body weight, N."""
        return GRAVITY * float(self.model.mujoco.body_subtreemass[0])

    @property
    def _ahead(self) -> float:
        """How far implicit springs look ahead, s."""
        return self.timestep if self.integrator == "implicit" else 0.0

    def motor_torque(self, state: State, action: HipTargets, terrain: Terrain) -> Float[Array, "2"]:
        """Returns the torques of the hips' motors in the step that follows, N m."""
        axes = floating.rotation(state.qpos[EULER])
        return self._accelerated(state, self._forward(state, axes), axes, action, terrain)[2]

    def _accelerated(
        self,
        state: State,
        data: Any,
        axes: Float[Array, "3 3"],
        action: HipTargets,
        terrain: Terrain,
    ) -> tuple[ContactForce, Float[Array, "14"], Float[Array, "2"]]:
        """Returns contacts, accelerations in the trunk's axes, and torques of the motors."""
        contacts, loads = self._contacts(state, data, axes, terrain)
        loads |= self._load(state, axes, terrain)
        force, inertia = self._passive_forces(state, axes)
        matrix, right = dynamics.equations(self.floating, data, force, inertia, loads)
        return contacts, *self._driven(state, action, matrix, right)

    def _forward(self, state: State, axes: Float[Array, "3 3"]) -> Any:
        """Returns positions, velocities and bias forces in the trunk's axes."""
        return floating.forward_from_euler(self.floating, state.qpos, state.qvel, axes, GRAVITY)

    def _contacts(
        self, state: State, data: Any, axes: Float[Array, "3 3"], terrain: Terrain
    ) -> tuple[ContactForce, dict[int, list[dynamics.PointLoad]]]:
        """Returns the ground's force on the spheres' lowest points, and the same as loads."""

        def push(
            offset: Array, velocity: Array, stretch: Array
        ) -> tuple[ContactForce, dynamics.PointLoad]:
            place = state.qpos[:3] + axes @ offset
            velocity = axes @ velocity
            contact = self.contact.force(
                self.terrain.height(terrain, place[0]) - place[2],
                (velocity[:2], velocity[2]),
                stretch,
                timestep=self.timestep,
                implicit=self.integrator == "implicit",
            )
            force = jnp.append(contact.tangential, contact.normal) @ axes
            return contact, dynamics.PointLoad(offset, force, contact.added_mass)

        feet = [self.floating.mujoco.body(foot).id for foot in FEET]
        bodies = np.repeat(feet, 2)
        centres = jnp.stack([self._sphere(x) for x in (self.heel, self.toe)] * 2)
        offsets = data.xpos[bodies] + (data.xmat[bodies] @ centres[:, :, None])[:, :, 0]
        offsets -= SPHERE_RADIUS * axes[2]
        velocities = jax.vmap(lambda motion, r: motion[3:] + jnp.cross(motion[:3], r))(
            data.cvel[bodies], offsets
        )
        contacts, loads = jax.vmap(push)(offsets, velocities, state.stretch)
        by_body: dict[int, list[dynamics.PointLoad]] = {}
        for index, body in enumerate(bodies.tolist()):
            load = jax.tree.map(operator.itemgetter(index), loads)
            by_body.setdefault(body, []).append(load)
        return contacts, by_body

    def _sphere(self, x: float) -> Float[Array, "3"]:
        """Returns where the centre of a foot's sphere is in the foot's axes, m."""
        return jnp.stack([jnp.asarray(part, jnp.float32) for part in (x, 0.0, -self.sole)])

    def _load(
        self, state: State, axes: Float[Array, "3 3"], terrain: Terrain
    ) -> dict[int, list[dynamics.PointLoad]]:
        """Returns what the trunk carries: weight, inertia, and what holds it on its curve."""
        if not self.terrain.load:
            return {}
        mass = self.terrain.drawn(terrain, "load")
        offset = jnp.array([0.0, 0.0, self.trunk_height])
        spin = floating.spin(state.qpos[EULER], state.qvel[EULER])
        curving = jnp.cross(spin, jnp.cross(spin, offset))
        force = -mass * (GRAVITY * axes[2] + curving)
        return {self.floating.mujoco.body("torso").id: [dynamics.PointLoad(offset, force, mass)]}

    def _passive_forces(
        self, state: State, axes: Float[Array, "3 3"]
    ) -> tuple[Float[Array, "14"], Float[Array, "14"]]:
        """Returns forces of springs, stops and assistance, N m, and their implicit part, kg m^2."""
        angle, rate = state.qpos[JOINTS], state.qvel[JOINTS]
        implicit = self.integrator == "implicit"
        stop = self.knee_cap.torque(
            angle, rate, *self._ranges(), timestep=self.timestep, implicit=implicit
        )
        springs = self._springs()
        torque = motor.torque(springs, angle, rate, ahead=self._ahead) + stop.torque
        inertia = stop.added_inertia
        inertia += motor.added_inertia(springs, self.timestep) if implicit else 0.0
        righting, resistance = self._assistance(state, axes)
        # The trunk's translation comes first, then its rotation about its own axes.
        force = jnp.concatenate([jnp.zeros(3), righting, torque])
        return force, jnp.concatenate([jnp.zeros(3), resistance, inertia])

    def _ranges(self) -> tuple[Float[np.ndarray, "8"], Float[np.ndarray, "8"]]:
        """Returns where the stops of the joints begin, rad; only knees have any."""
        lower, upper = np.full(8, -np.inf, np.float32), np.full(8, np.inf, np.float32)
        lower[KNEES], upper[KNEES] = self.knee_extension, self.knee_flexion
        return lower, upper

    def _springs(self) -> motor.Action:
        """Returns the springs and dampers of hip roll, hip, knee and ankle of each leg."""
        joints = [0.0, 0.0, 0.0, self.ankle_rest]
        stiffness = [self.hip_roll_stiffness, 0.0, 0.0, self.ankle_stiffness]
        damping = [self.hip_roll_damping, 0.0, self.knee_damping, self.ankle_damping]
        rest, stiff, damped = (
            jnp.stack([jnp.asarray(part, jnp.float32) for part in parts] * 2)
            for parts in (joints, stiffness, damping)
        )
        return motor.Action(jnp.zeros(8), rest, stiff, damped)

    def _assistance(
        self, state: State, axes: Float[Array, "3 3"]
    ) -> tuple[Float[Array, "3"], Float[Array, "3"]]:
        """Returns the torque that rights the trunk about its own axes, and its implicit part.

        It turns the trunk's vertical towards the world's, or towards one that leans; yaw is free.
        """
        if not (self.assistance or self.assistance_damping):
            return jnp.zeros(3), jnp.zeros(3)
        damping = self.assistance_damping + self._ahead * self.assistance
        spin = floating.spin(state.qpos[EULER], state.qvel[EULER])
        forward, left, _ = axes[2]
        off = jnp.stack([-left, forward + jnp.sin(self.assistance_lean), jnp.zeros(())])
        tilting = jnp.array([self.assistance_roll, 1.0, 0.0])
        righting = (self.assistance * off - damping * spin) * tilting
        return righting, tilting * self._ahead * damping

    def _driven(
        self,
        state: State,
        action: HipTargets,
        matrix: Float[Array, "14 14"],
        force: Float[Array, "14"],
    ) -> tuple[Float[Array, "14"], Float[Array, "2"]]:
        """Returns the accelerations with motors, in the trunk's axes, and the motors' torques."""
        coasting = dynamics.solve(matrix, force)
        answers = [dynamics.solve(matrix, one) for one in jnp.eye(NUM_COORDINATES)[HIPS]]
        answer = jnp.stack(answers)
        angle, rate = state.qpos[HIPS], state.qvel[HIPS]
        wanted = self.hips.request(action.angle, angle) - rate - self.timestep * coasting[HIPS]
        torque = self.hips.torques(self.timestep * answer[:, HIPS], wanted)
        return coasting + torque @ answer, torque
