"""Planar walker of seven links: upper body, thighs, shanks and feet, after a human of 70 kg.

Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and 3D bipedal
walking over rough terrain", Adaptive Behavior 21(1), doi 10.1177/1059712312462904, sections 2.1 to
2.3. Nine degrees of freedom: the hip's x and z, the upper body's pitch, and hip, knee and ankle of
each leg. Flexion, dorsiflexion and forward lean are positive. The body is in `planar7.xml`, or in a
file of the user's, see `planar7_body.py`.
"""

import dataclasses
from typing import Any, Literal, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from mjxwalk.envs import checks, dynamics, edge, motor, planar7_body, trial
from mjxwalk.envs.contact import ContactForce, SoftContact
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.motor import Action
from mjxwalk.envs.planar7_body import (
    ACTUATED,
    CONTACT_SITES,
    FEET,
    GRAVITY,
    Masses,
)
from mjxwalk.envs.terrain import RandomWalk, Terrain

# ours: beyond these speeds a simulation has diverged; a foot that spins free reaches 100 rad/s.
MAX_SPEED = np.array([50.0] * 2 + [1000.0] * 7, np.float32)  # m/s, rad/s


class Observation(NamedTuple):
    """What the walker senses; legs in the order left, right.

    Attributes:
      time: since the start, s.
      pitch: of the upper body, rad, forward lean positive.
      pitch_rate: rad/s.
      angle: hip, knee and ankle of each leg, rad.
      rate: of the same, rad/s.
      contact: whether heel or toe of the foot touch the ground.
      ankle_x: how far each ankle is ahead of the hip, m.
    """

    time: Float[Array, ""]
    pitch: Float[Array, ""]
    pitch_rate: Float[Array, ""]
    angle: Float[Array, "2 3"]
    rate: Float[Array, "2 3"]
    contact: Bool[Array, "2"]
    ankle_x: Float[Array, "2"]


class State(NamedTuple):
    """One walker between two steps; contacts and ankles are those that the last step saw.

    Attributes:
      qpos: hip x and z (m), pitch and joints (rad).
      qvel: m/s and rad/s.
      stretch: of the ground's tangential springs, m: heel and toe of the left, then the right foot.
      touching: whether those points are below the ground.
      ankle_x: how far each ankle is ahead of the hip, m.
      num_steps: physics steps so far.
      flight_time: since a foot last touched the ground, s.
      torque_cost: integral of the joints' summed absolute torque, N m s.
      work: integral of the joints' summed absolute power, J.
      fell: whether the trial ended by a fall, or by physics that diverged.
      diverged: whether the physics diverged; the rest is then the last sound state.
      done: whether the trial has ended.
    """

    qpos: Float[Array, "9"]
    qvel: Float[Array, "9"]
    stretch: Float[Array, "4"]
    touching: Bool[Array, "4"]
    ankle_x: Float[Array, "2"]
    num_steps: Int[Array, ""]
    flight_time: Float[Array, ""]
    torque_cost: Float[Array, ""]
    work: Float[Array, ""]
    fell: Bool[Array, ""]
    diverged: Bool[Array, ""]
    done: Bool[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Planar7:
    """The body, its ground, and the rules of a trial.

    Attributes:
      body: MJCF of a user's body, "" for ours; `mjxwalk.experiments.own_body` takes the masses and
        what hangs on lengths from it.
      torso_mass: kg; a link's moment of inertia scales with its mass.
      thigh_mass: kg, each.
      shank_mass: kg, each.
      foot_mass: kg, each.
      terrain: shape of the ground.
      contact: law of the ground.
      joint_stop: law of the joints' limits.
      timestep: of the physics, s.
      integrator: "implicit" takes contact, joint stops and the action's stiffness and damping at
        the end of the step, which is stable at 1 ms; "explicit" takes all forces at its start, as
        the paper does at 0.2 ms. Positions then follow the new velocities (semi-implicit Euler).
      start_hip_angle: left hip at the start, rad; the right hip is at minus that.
      min_hip_height: over the ground below, m; under it the walker has fallen.
      max_pitch: of the upper body, rad; beyond it the walker has fallen.
      max_flight_time: s without ground contact; beyond it the walker has fallen.
      min_speed: the trial ends when the walker is farther behind one of this speed than
        `max_lag`, m/s.
      max_lag: see `min_speed`, m.
      torque_budget: the trial ends when `torque_cost` reaches it, N m s.
      max_time: the trial ends then, s.
    """

    body: str = dataclasses.field(default="", repr=False)
    torso_mass: float = 47.46
    thigh_mass: float = 7.0
    shank_mass: float = 3.255
    foot_mass: float = 1.015
    terrain: RandomWalk = RandomWalk()
    contact: SoftContact = SoftContact()
    joint_stop: JointStop = JointStop()
    timestep: float = 0.001  # ours: the paper's 0.0002 s is for the explicit integrator
    integrator: Literal["implicit", "explicit"] = "implicit"
    start_hip_angle: float = 0.15  # ours: staggered feet bootstrap, side by side they lunge
    min_hip_height: float = 0.78  # ours: the paper gives no rule; a lower one lets crouchers win
    max_pitch: float = 1.0  # ours: as above
    max_flight_time: float = 0.002  # flight is a fall, section 2.4; ours: bounces are shorter
    min_speed: float = 0.25  # ours: far below any gait; a walker that stands wins nothing by time
    max_lag: float = 1.0  # ours: 4 s to set off
    torque_budget: float = 28_000.0  # ours: the 3D budget scaled by weight and leg length, times 3
    max_time: float = 30.0  # ours: standing still costs little torque

    def __post_init__(self) -> None:
        checks.positive(self, "torso_mass", "thigh_mass", "shank_mass", "foot_mass", "timestep")
        checks.positive(self, "min_hip_height", "max_pitch", "torque_budget", "max_time")
        checks.not_negative(self, "max_flight_time", "min_speed", "max_lag")
        checks.steps(self)
        if self.integrator not in ("implicit", "explicit"):
            raise ValueError(
                f'integrator must be "implicit" or "explicit", got "{self.integrator}"'
            )
        if self.body:
            planar7_body.check(self.body)
            planar7_body.check_start(self.body, self.start_hip_angle)

    @property
    def weight(self) -> float:
        """Body weight, N."""
        return GRAVITY * float(self.model.mujoco.body_subtreemass[0])

    @property
    def model(self) -> dynamics.Model:
        """The compiled body."""
        return planar7_body.compile_body(self.body, self.masses)

    @property
    def masses(self) -> Masses:
        """Of the links, kg."""
        return Masses(self.torso_mass, self.thigh_mass, self.shank_mass, self.foot_mass)

    @property
    def leg_length(self) -> float:
        """Hip to floor with the leg straight, m."""
        return planar7_body.sizes(self.body).leg

    @property
    def sole_depth(self) -> float:
        """Ankle to sole, m."""
        return planar7_body.sizes(self.body).sole

    @property
    def limits(self) -> motor.Limits | None:
        """Of the motors; None if none is limited."""
        return planar7_body.limits(self.model.mujoco)

    @edge.takes_arrays
    def reset(self, terrain: Terrain) -> State:
        """Returns a walker at rest, one leg ahead of the other, soles level on the ground."""
        hip = self.start_hip_angle
        leg, sole = self.leg_length, self.sole_depth
        qpos = jnp.array([0.0, leg * np.cos(hip), 0.0, hip, 0.0, -hip, -hip, 0.0, hip])
        ground = self.terrain.height(terrain, qpos[0])
        ahead = (leg - sole) * np.sin(hip)
        return State(
            qpos=qpos.at[1].add(ground - sole * (np.cos(hip) - 1.0)),
            qvel=jnp.zeros(9),
            stretch=jnp.zeros(4),
            touching=jnp.ones(4, bool),
            ankle_x=jnp.array([ahead, -ahead]),
            **trial.begin(),
        )

    @edge.takes_arrays
    def observe(self, state: State) -> Observation:
        """Returns what the walker senses."""
        return Observation(
            time=state.num_steps * self.timestep,
            pitch=state.qpos[2],
            pitch_rate=state.qvel[2],
            angle=state.qpos[ACTUATED].reshape(2, 3),
            rate=state.qvel[ACTUATED].reshape(2, 3),
            contact=jnp.any(state.touching.reshape(2, 2), axis=1),
            ankle_x=state.ankle_x,
        )

    @edge.takes_arrays
    def step(self, state: State, action: Action, terrain: Terrain) -> State:
        """Returns the walker one physics step later, and whether its trial is over.

        The action is that of hip, knee and ankle of the left leg, then of the right one. What the
        motors give counts as cost and work; joint stops are no motors.
        """
        # The tree is placed at the origin: what it does there does not depend on where it is, and
        # near the origin float32 is finer.
        data = dynamics.forward(self.model, state.qpos.at[:2].set(0.0), state.qvel)
        contacts, loads = self._contacts(state, data, terrain)
        torque, inertia = self._joint_forces(state, action)
        on_root = jnp.zeros(3)
        qacc = dynamics.acceleration(
            self.model,
            data,
            jnp.concatenate([on_root, torque]),
            jnp.concatenate([on_root, inertia]),
            loads,
        )
        qvel = state.qvel + self.timestep * qacc
        qpos = state.qpos + self.timestep * qvel
        rate = (qvel if self.integrator == "implicit" else state.qvel)[ACTUATED]
        rates = state.qvel[ACTUATED], rate
        applied = motor.given(action, state.qpos[ACTUATED], rates, self.limits, ahead=self._ahead)
        touching = jnp.stack([contact.touching for contact in contacts])
        ankles = jnp.stack([data.xpos[self.model.mujoco.body(foot).id, 0] for foot in FEET])
        moved = state._replace(
            qpos=qpos,
            qvel=qvel,
            stretch=jnp.stack([contact.stretch for contact in contacts]),
            touching=touching,
            ankle_x=ankles,
        )
        moved = trial.count(self, moved, touching=touching, torque=applied, rate=qvel[ACTUATED])

        def has_fallen(after: State) -> Bool[Array, ""]:
            height = after.qpos[1] - self.terrain.height(terrain, after.qpos[0])
            return (height < self.min_hip_height) | (jnp.abs(after.qpos[2]) > self.max_pitch)

        return trial.judge(self, state, moved, max_speed=MAX_SPEED, has_fallen=has_fallen)

    @property
    def _ahead(self) -> float:
        """How far implicit motors look ahead, s."""
        return self.timestep if self.integrator == "implicit" else 0.0

    def _contacts(
        self, state: State, data: Any, terrain: Terrain
    ) -> tuple[list[ContactForce], dict[int, list[dynamics.PointLoad]]]:
        """Returns the ground's force on heels and toes, and the same as loads on the feet."""
        contacts: list[ContactForce] = []
        loads: dict[int, list[dynamics.PointLoad]] = {}
        model = self.model.mujoco
        for index, name in enumerate(CONTACT_SITES):
            site = model.site(name).id
            body = int(model.site_bodyid[site])
            point = data.site_xpos[site]
            offset = dynamics.point_offset(data, point)
            velocity = dynamics.point_velocity(data, body, offset)
            ground = self.terrain.height(terrain, state.qpos[0] + point[0])
            contact = self.contact.force(
                ground - (state.qpos[1] + point[2]),
                (velocity[0], velocity[2]),
                state.stretch[index],
                timestep=self.timestep,
                implicit=self.integrator == "implicit",
            )
            force = jnp.stack([contact.tangential, jnp.zeros(()), contact.normal])
            load = dynamics.PointLoad(offset, force, contact.added_mass)
            contacts.append(contact)
            loads.setdefault(body, []).append(load)
        return contacts, loads

    def _joint_forces(
        self, state: State, action: Action
    ) -> tuple[Float[Array, "6"], Float[Array, "6"]]:
        """Returns the joints' torque, N m, and its implicit part as inertia, kg m^2."""
        angle, rate = state.qpos[ACTUATED], state.qvel[ACTUATED]
        implicit = self.integrator == "implicit"
        lower, upper = planar7_body.stops(self.model.mujoco)
        stop = self.joint_stop.torque(
            angle, rate, lower, upper, timestep=self.timestep, implicit=implicit
        )
        drive = motor.driven(action, angle, rate, self.limits, ahead=self._ahead)
        springs = planar7_body.springs(self.model.mujoco)
        passive = motor.sprung(springs, angle, rate, ahead=self._ahead)
        return motor.total(drive, stop, passive)
