"""Spatial walker of nine links after the robot Flame: a torso and two legs of four links.

Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and 3D bipedal
walking over rough terrain", Adaptive Behavior 21(1), doi 10.1177/1059712312462904, sections 2.1 and
3.5. The body is in `flame.xml` and `flame_body.py`, or in a file of the user's.
"""

import dataclasses
import operator
from typing import Any, Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from mjxwalk.envs import checks, dynamics, edge, flame_body, floating, motor, trial
from mjxwalk.envs.contact import ContactForce, SoftContact
from mjxwalk.envs.flame_body import (
    ACTUATED,
    ADDUCTION,
    ANKLE_ROLLS,
    CONTACT_SITES,
    COORDINATE,
    COUPLING,
    EULER,
    FEET,
    GRAVITY,
    JOINTS,
    MAX_SPEED,
    PITCH,
    ROLL,
    on_joints,
)
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.motor import Action
from mjxwalk.envs.surface import SerpentineWalk
from mjxwalk.envs.terrain import Terrain


class Observation(NamedTuple):
    """What the walker senses; legs in the order left, right.

    Attributes:
      time: since the start, s.
      torso: its yaw, pitch and roll, rad: turning left, leaning forward and right are positive.
      torso_rate: of the same, rad/s.
      adduction: angle of both legs to the torso, rad, legs apart positive.
      adduction_rate: rad/s.
      angle: hip, knee, ankle and ankle roll of each leg, rad.
      rate: of the same, rad/s.
      contact: whether the foot touches the ground.
      ankle_x: how far each ankle is ahead of the hip, where the torso heads, m.
    """

    time: Float[Array, ""]
    torso: Float[Array, "3"]
    torso_rate: Float[Array, "3"]
    adduction: Float[Array, ""]
    adduction_rate: Float[Array, ""]
    angle: Float[Array, "2 4"]
    rate: Float[Array, "2 4"]
    contact: Bool[Array, "2"]
    ankle_x: Float[Array, "2"]


class State(NamedTuple):
    """One walker between two steps; contacts and ankles are those that the last step saw.

    Attributes:
      qpos: the coordinates: hip x, y and z (m), torso's yaw, pitch and roll, joints (rad).
      qvel: m/s and rad/s.
      stretch: of the ground's tangential springs along x and y, m, in `CONTACT_SITES`' order.
      touching: whether those points are below the ground.
      ankle_x: how far each ankle is ahead of the hip, where the torso heads, m.
      num_steps: physics steps so far.
      flight_time: since a foot last touched the ground, s.
      torque_cost: integral of the motors' summed absolute torque, N m s.
      work: integral of the motors' summed absolute power, J.
      fell: whether the trial ended by a fall, or by physics that diverged.
      diverged: whether the physics diverged; the rest is then the last sound state.
      done: whether the trial has ended.
    """

    qpos: Float[Array, "15"]
    qvel: Float[Array, "15"]
    stretch: Float[Array, "8 2"]
    touching: Bool[Array, "8"]
    ankle_x: Float[Array, "2"]
    num_steps: Int[Array, ""]
    flight_time: Float[Array, ""]
    torque_cost: Float[Array, ""]
    work: Float[Array, ""]
    fell: Bool[Array, ""]
    diverged: Bool[Array, ""]
    done: Bool[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Flame:
    """The body, its ground, and the rules of a trial.

    Attributes:
      body: MJCF of a user's body, "" for ours; `mjxwalk.experiments.own_body` takes what hangs on
        its size from it.
      terrain: shape of the ground.
      contact: law of the ground at each of a foot's four corners.
      joint_stop: law of the joints' limits.
      ankle_roll_stiffness: of the passive spring, N m/rad.
      ankle_roll_damping: of the passive damper, N m s/rad.
      timestep: of the physics, s.
      integrator: "implicit" takes contact, joint stops, the ankle's roll and the action's stiffness
        and damping at the end of the step, which is stable at 1 ms; "explicit" takes all forces at
        its start and needs 0.02 ms. Positions follow the new velocities (semi-implicit Euler).
      min_hip_height: over the ground below, m; under it the walker has fallen.
      max_pitch: of the torso, rad; beyond it the walker has fallen.
      max_roll: likewise.
      max_yaw: likewise.
      max_flight_time: s without ground contact; beyond it the walker has fallen.
      min_speed: the trial ends when the walker is farther behind one of this speed than
        `max_lag`, m/s.
      max_lag: see `min_speed`, m.
      torque_budget: the trial ends when `torque_cost` reaches it, N m s.
      max_time: the trial ends then, s.
    """

    body: str = dataclasses.field(default="", repr=False)
    terrain: SerpentineWalk = SerpentineWalk()
    # A quarter each of the foot's 50,000 N/m and 2,500 N s/m, section 2.3.
    contact: SoftContact = SoftContact(stiffness=12_500.0, damping=625.0)
    joint_stop: JointStop = JointStop(stiffness=1_000.0, damping=10.0)  # ours: see JointStop
    ankle_roll_stiffness: float = 10.0  # ours: not given
    ankle_roll_damping: float = 0.2  # ours: not given
    timestep: float = 0.001  # section 2.3
    integrator: Literal["implicit", "explicit"] = "implicit"
    min_hip_height: float = 0.555  # ours: the paper gives no rule; a lower one lets crouchers win
    max_pitch: float = 0.5  # ours: keeps walkers upright
    max_roll: float = 0.7  # ours
    max_yaw: float = 1.2  # ours: who turns away from x does not come far
    max_flight_time: float = 0.01  # flight is a fall, section 2.4; ours: bounces are shorter
    min_speed: float = 0.25  # ours: far below any gait; a walker that stands wins nothing by time
    max_lag: float = 1.0  # ours: 4 s to set off
    torque_budget: float = 1_000.0  # section 3.5.1
    max_time: float = 60.0  # ours: standing still costs little torque

    def __post_init__(self) -> None:
        checks.positive(self, "timestep", "min_hip_height", "max_pitch", "max_roll", "max_yaw")
        checks.positive(self, "torque_budget", "max_time")
        checks.not_negative(self, "ankle_roll_stiffness", "ankle_roll_damping", "max_flight_time")
        checks.not_negative(self, "min_speed", "max_lag")
        checks.steps(self)
        if self.integrator not in ("implicit", "explicit"):
            raise ValueError(
                f'integrator must be "implicit" or "explicit", got "{self.integrator}"'
            )
        if self.body:
            flame_body.check(self.body)

    @property
    def model(self) -> dynamics.Model:
        """The compiled body."""
        return flame_body.hinged_model(self.body)

    @property
    def floating(self) -> dynamics.Model:
        """The same with a free root, as `mjxwalk.envs.floating` takes it."""
        return flame_body.floating_model(self.body)

    @property
    def weight(self) -> float:
        """Body weight, N."""
        return GRAVITY * float(self.model.mujoco.body_subtreemass[0])

    @property
    def leg_length(self) -> float:
        """Hip to floor with the leg straight, m."""
        return flame_body.leg_length(self.body)

    @property
    def limits(self) -> motor.Limits | None:
        """Of the motors; None if none is limited."""
        return flame_body.limits(self.body)

    @edge.takes_arrays
    def reset(self, terrain: Terrain) -> State:
        """Returns a walker in the middle of a step, the left foot in the air."""
        depth = self.weight / (4.0 * self.contact.stiffness)
        qpos, qvel, ankle_x = flame_body.start(self.body, depth)
        ground = self.terrain.height(terrain, jnp.zeros(()), jnp.zeros(()))
        return State(
            qpos=jnp.asarray(qpos).at[2].add(ground),
            qvel=jnp.asarray(qvel),
            stretch=jnp.zeros((8, 2)),
            touching=jnp.arange(8) >= 4,
            ankle_x=jnp.asarray(ankle_x),
            **trial.begin(),
        )

    @edge.takes_arrays
    def observe(self, state: State) -> Observation:
        """Returns what the walker senses."""
        return Observation(
            time=state.num_steps * self.timestep,
            torso=state.qpos[EULER],
            torso_rate=state.qvel[EULER],
            adduction=state.qpos[ADDUCTION],
            adduction_rate=state.qvel[ADDUCTION],
            angle=state.qpos[ADDUCTION + 1 :].reshape(2, 4),
            rate=state.qvel[ADDUCTION + 1 :].reshape(2, 4),
            contact=jnp.any(state.touching.reshape(2, 4), axis=1),
            ankle_x=state.ankle_x,
        )

    @edge.takes_arrays
    def step(self, state: State, action: Action, terrain: Terrain) -> State:
        """Returns the walker one physics step later, and whether its trial is over.

        The action is that of adduction, then of hip, knee and ankle of the left leg, then of the
        right one. What the motors give counts as cost and work; stops and springs are no motors.
        """
        axes = floating.rotation(state.qpos[EULER])
        data = self._forward(state, axes)
        contacts, loads = self._contacts(state, data, axes, terrain)
        torque, inertia = self._joint_forces(state, action)
        qacc = dynamics.acceleration(
            self.floating, data, on_joints(torque), on_joints(inertia), loads, COUPLING
        )
        turning = floating.euler_acceleration(state.qpos[EULER], state.qvel[EULER], qacc[EULER])
        qacc = jnp.concatenate([axes @ qacc[:3], turning, qacc[JOINTS]])
        qvel = state.qvel + self.timestep * qacc
        rate = (qvel if self.integrator == "implicit" else state.qvel)[ACTUATED]
        rates = state.qvel[ACTUATED], rate
        applied = motor.given(action, state.qpos[ACTUATED], rates, self.limits, ahead=self._ahead)
        ankles = data.xpos[np.array([self.floating.mujoco.body(foot).id for foot in FEET])]
        # Seen along the torso's pitch, the heading is level.
        cosine, sine = jnp.cos(state.qpos[PITCH]), jnp.sin(state.qpos[PITCH])
        ahead = jnp.stack(
            [cosine, sine * jnp.sin(state.qpos[ROLL]), sine * jnp.cos(state.qpos[ROLL])]
        )
        moved = state._replace(
            qpos=state.qpos + self.timestep * qvel,
            qvel=qvel,
            stretch=contacts.stretch,
            touching=contacts.touching,
            ankle_x=ankles @ ahead,
        )
        moved = trial.count(
            self, moved, touching=contacts.touching, torque=applied, rate=qvel[ACTUATED]
        )

        def has_fallen(after: State) -> Bool[Array, ""]:
            x, y, z, yaw, pitch, roll = after.qpos[:6]
            return (
                (z - self.terrain.height(terrain, x, y) < self.min_hip_height)
                | (jnp.abs(yaw) > self.max_yaw)
                | (jnp.abs(pitch) > self.max_pitch)
                | (jnp.abs(roll) > self.max_roll)
            )

        return trial.judge(self, state, moved, max_speed=MAX_SPEED, has_fallen=has_fallen)

    @property
    def _ahead(self) -> float:
        """How far implicit motors look ahead, s."""
        return self.timestep if self.integrator == "implicit" else 0.0

    def _forward(self, state: State, axes: Float[Array, "3 3"]) -> Any:
        """Returns positions, velocities and bias forces in the torso's axes."""
        return floating.forward_from_euler(
            self.floating, state.qpos[COORDINATE], state.qvel[COORDINATE], axes, GRAVITY
        )

    def _contacts(
        self, state: State, data: Any, axes: Float[Array, "3 3"], terrain: Terrain
    ) -> tuple[ContactForce, dict[int, list[dynamics.PointLoad]]]:
        """Returns the ground's force on the feet's corners, and the same as loads on the feet."""

        def push(
            offset: Array, velocity: Array, stretch: Array
        ) -> tuple[ContactForce, dynamics.PointLoad]:
            x, y, z = state.qpos[:3] + axes @ offset
            velocity = axes @ velocity
            contact = self.contact.force(
                self.terrain.height(terrain, x, y) - z,
                (velocity[:2], velocity[2]),
                stretch,
                timestep=self.timestep,
                implicit=self.integrator == "implicit",
            )
            force = jnp.append(contact.tangential, contact.normal) @ axes
            return contact, dynamics.PointLoad(offset, force, contact.added_mass)

        model = self.floating.mujoco
        sites = np.array([model.site(name).id for name in CONTACT_SITES])
        bodies = model.site_bodyid[sites]
        corners = model.site_pos[sites].astype(np.float32)
        offsets = data.xpos[bodies] + (data.xmat[bodies] @ corners[:, :, None])[:, :, 0]
        velocities = jax.vmap(lambda motion, r: motion[3:] + jnp.cross(motion[:3], r))(
            data.cvel[bodies], offsets
        )
        contacts, loads = jax.vmap(push)(offsets, velocities, state.stretch)
        by_body: dict[int, list[dynamics.PointLoad]] = {}
        for index, body in enumerate(bodies.tolist()):
            load = jax.tree.map(operator.itemgetter(index), loads)
            by_body.setdefault(body, []).append(load)
        return contacts, by_body

    def _joint_forces(
        self, state: State, action: Action
    ) -> tuple[Float[Array, "9"], Float[Array, "9"]]:
        """Returns the joints' torque, N m, and its implicit part as inertia, kg m^2."""
        angle, rate = state.qpos[JOINTS], state.qvel[JOINTS]
        implicit = self.integrator == "implicit"
        lower, upper = flame_body.joint_ranges(self.body)
        stop = self.joint_stop.torque(
            angle, rate, lower, upper, timestep=self.timestep, implicit=implicit
        )
        driven = self._with_springs(action)
        drive = motor.driven(driven, angle, rate, self._joint_limits, ahead=self._ahead)
        passive = motor.sprung(flame_body.springs(self.body), angle, rate, ahead=self._ahead)
        return motor.total(drive, stop, passive)

    @property
    def _joint_limits(self) -> motor.Limits | None:
        """The motors' limits on all nine joints."""
        if self.limits is None:
            return None
        lowest, highest = np.full(9, -np.inf, np.float32), np.full(9, np.inf, np.float32)
        motors = ACTUATED - JOINTS.start
        lowest[motors], highest[motors] = self.limits
        return motor.Limits(lowest, highest)

    def _with_springs(self, action: Action) -> Action:
        """Returns the action of all nine joints: the ankles' rolls are passive springs."""
        roll, motors = ANKLE_ROLLS - JOINTS.start, ACTUATED - JOINTS.start
        spread = Action(*(jnp.zeros(9).at[motors].set(part) for part in action))
        return spread._replace(
            stiffness=spread.stiffness.at[roll].set(self.ankle_roll_stiffness),
            damping=spread.damping.at[roll].set(self.ankle_roll_damping),
        )
