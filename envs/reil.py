"""Spatial biped with powered hips: trunk and two legs of hip, thigh, calf and foot.

Reil & Massey (2001), "Facilitating controller evolution in morpho-functional machines - a bipedal
case study", sections 3 and 4. Each leg has hip roll, hip pitch, knee and ankle; motors drive the
hips' pitch alone, as in section 4.2. Knees swing freely up to a soft knee cap, ankles are damped
springs, and a foot is two spheres. The body is in `reil.xml` and `reil_body.py`.
"""

import dataclasses
import operator
from typing import Any, Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from mjxwalk.envs import checks, dynamics, floating, motor, trial
from mjxwalk.envs.contact import ContactForce, SoftContact
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.reil_body import (
    EULER,
    FEET,
    GRAVITY,
    HIPS,
    JOINTS,
    KNEES,
    LEG,
    MAX_SPEED,
    NUM_COORDINATES,
    SPHERE_RADIUS,
    YAW,
    Offsets,
    floating_model,
    hinged_model,
    standing_height,
)
from mjxwalk.envs.reil_trials import TrialVariation
from mjxwalk.envs.terrain import Terrain
from mjxwalk.envs.velocity_motor import VelocityMotor


class HipTargets(NamedTuple):
    """What a controller asks of the motors.

    Attributes:
      angle: desired pitch of the left and the right hip, rad, forward positive.
    """

    angle: Float[Array, "2"]


class Observation(NamedTuple):
    """What the walker senses; legs in the order left, right.

    Attributes:
      time: since the start, s.
      torso: yaw, pitch and roll of the trunk, rad: turning left, leaning forward and right are
        positive.
      torso_rate: of the same, rad/s.
      angle: hip roll, hip, knee and ankle of each leg, rad.
      rate: of the same, rad/s.
      contact: whether the foot touches the ground.
      ankle_x: how far each ankle is ahead of the hips, m.
    """

    time: Float[Array, ""]
    torso: Float[Array, "3"]
    torso_rate: Float[Array, "3"]
    angle: Float[Array, "2 4"]
    rate: Float[Array, "2 4"]
    contact: Bool[Array, "2"]
    ankle_x: Float[Array, "2"]


class State(NamedTuple):
    """One walker between two steps; contacts and ankles are those that the last step saw.

    Attributes:
      qpos: the coordinates: the hips' midpoint x, y and z (m), yaw, pitch and roll of the trunk,
        joints (rad).
      qvel: m/s and rad/s.
      stretch: of the ground's tangential springs along x and y, m; heel and toe, left, then right.
      touching: whether those spheres touch the ground.
      ankle_x: how far each ankle is ahead of the hips, m.
      height: of the centre of mass over the ground, m.
      target: last desired angles of the hips, rad.
      still_time: since one of them last changed, s.
      num_steps: physics steps so far.
      flight_time: since a foot last touched the ground, s.
      torque_cost: integral of the motors' summed absolute torque, N m s.
      work: integral of the motors' summed absolute power, J.
      fell: whether the trial ended by a fall, or by physics that diverged.
      diverged: whether the physics diverged; the rest is then the last sound state.
      done: whether the trial has ended.
    """

    qpos: Float[Array, "14"]
    qvel: Float[Array, "14"]
    stretch: Float[Array, "4 2"]
    touching: Bool[Array, "4"]
    ankle_x: Float[Array, "2"]
    height: Float[Array, ""]
    target: Float[Array, "2"]
    still_time: Float[Array, ""]
    num_steps: Int[Array, ""]
    flight_time: Float[Array, ""]
    torque_cost: Float[Array, ""]
    work: Float[Array, ""]
    fell: Bool[Array, ""]
    diverged: Bool[Array, ""]
    done: Bool[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Reil:
    """The body, its ground, and the rules of a trial.

    The paper gives sizes, densities and the kinds of joints; all other numbers are ours, and
    docs/reil.md tells how much hangs on each.

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
      timestep: of the physics, s.
      integrator: "implicit" takes contact, stops, springs and dampers at the end of the step, which
        is stable at 2 ms; "explicit" at its start. Motors are always those of the end of the step.
        Positions follow the new velocities (semi-implicit Euler).
      min_height: of the centre of mass over the ground, as a share of that when standing; under it
        the walker has fallen.
      max_yaw: rad; beyond it the walker counts as fallen.
      max_flight_time: s without ground contact; beyond it the walker has fallen.
      fallen_distance: a walker that falls before its hindmost foot is that far has fitness 0, m.
      still_rate: desired angles that change slower than this stand still, rad/s.
      max_still_time: the trial ends when they have for so long, s.
      min_speed: the trial ends when the walker is farther behind one of this speed than
        `max_lag`, m/s.
      max_lag: see `min_speed`, m.
      max_distance: the trial ends when the hindmost foot is there, m.
      torque_budget: the trial ends when `torque_cost` reaches it, N m s.
      max_time: the trial ends then, s.
    """

    terrain: TrialVariation = TrialVariation()
    contact: SoftContact = SoftContact(stiffness=150_000.0, damping=6_000.0)  # ours
    # ours: rigid motors walk less far; this softness is a damper of 1,000 N m s/rad
    hips: VelocityMotor = VelocityMotor(
        approach=29.0, max_speed=3.9, max_torque=1_130.0, softness=0.001
    )
    hip_offset: float = 0.125  # ours: the hips' spheres touch
    trunk_height: float = 0.3  # ours: the trunk begins at the hips
    heel: float = -0.1  # ours
    toe: float = 0.18  # ours
    sole: float = 0.04  # ours
    hip_roll_stiffness: float = 20_000.0  # ours: held, as no motor neuron drives it
    hip_roll_damping: float = 1_000.0  # ours
    knee_cap: JointStop = JointStop(stiffness=5_000.0, damping=60.0)  # ours
    knee_extension: float = -0.24  # ours: a straight knee gives way under load
    knee_flexion: float = 2.0  # ours
    knee_damping: float = 180.0  # ours: far too much to swing freely; with less few walk
    ankle_stiffness: float = 1_550.0  # ours
    ankle_damping: float = 42.0  # ours
    ankle_rest: float = 0.31  # ours: with the knee bent back, the foot is level
    assistance: float = 0.0
    assistance_damping: float = 0.0
    assistance_lean: float = 0.0
    timestep: float = 0.002  # ours: the paper gives none
    integrator: Literal["implicit", "explicit"] = "implicit"
    min_height: float = 0.8  # ours: the paper has such a threshold and does not tell it
    max_yaw: float = 1.0  # ours: who turns away from x does not come far
    max_flight_time: float = 0.1  # ours: who flies does not walk; bounces are shorter
    fallen_distance: float = 0.3  # ours: likewise the paper's; less than a step
    still_rate: float = 1e-3  # ours: the paper has the network reach a point
    max_still_time: float = 1.5  # ours: the body has come to rest by then
    min_speed: float = 0.25  # ours: a third of the paper's average; who stands costs time
    max_lag: float = 1.5  # ours: 6 s to set off
    max_distance: float = 20.0  # section 5: the milestone
    torque_budget: float = 1e6  # ours: the paper has none; more than any trial spends
    max_time: float = 40.0  # ours: 20 m at 0.5 m/s

    def __post_init__(self) -> None:
        checks.positive(self, "timestep", "hip_offset", "max_distance", "torque_budget", "max_time")
        checks.positive(self, "knee_flexion", "min_height", "max_yaw")
        checks.not_negative(self, "hip_roll_stiffness", "hip_roll_damping", "knee_damping")
        checks.not_negative(self, "ankle_stiffness", "ankle_damping", "sole", "max_flight_time")
        checks.not_negative(self, "assistance", "assistance_damping", "fallen_distance")
        checks.not_negative(self, "still_rate", "max_still_time", "min_speed", "max_lag")
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

    def reset(self, terrain: Terrain) -> State:
        """Returns a walker that stands straight, or moves already as its trial has it.

        The soles are as deep in the ground as the weight presses them; of a body astride, or on a
        slope, the ankles are.
        """
        drawn = {name: self.terrain.drawn(terrain, name) for name in ("push", "sideways")}
        pitch_rate, stride = (self.terrain.drawn(terrain, n) for n in ("pitch_rate", "stride"))
        reach = LEG + self.sole + SPHERE_RADIUS
        leg_rate = drawn["push"] / (LEG * jnp.cos(stride))
        depth = self.weight / (4.0 * self.contact.stiffness)
        drop = self.sole + SPHERE_RADIUS
        nothing = jnp.zeros(())
        angles = [nothing, stride, nothing, -stride, nothing, -stride, nothing, stride]
        hip_rate, ankle_rate = pitch_rate - leg_rate, leg_rate
        rates = [nothing, hip_rate, nothing, ankle_rate] * 2
        height = LEG * jnp.cos(stride) + drop - depth
        tip = -drawn["sideways"] / reach
        root = [nothing, nothing, height, nothing, nothing, nothing]
        root_rate = [drawn["push"], drawn["sideways"], nothing, nothing, pitch_rate, tip]
        ahead = LEG * jnp.sin(stride)
        return State(
            qpos=jnp.stack(root + angles),
            qvel=jnp.stack(root_rate + rates),
            stretch=jnp.zeros((4, 2)),
            touching=jnp.ones(4, bool),
            ankle_x=jnp.stack([ahead, -ahead]),
            height=jnp.full((), standing_height(self.offsets)),
            target=jnp.zeros(2),
            still_time=nothing,
            **trial.begin(),
        )

    def observe(self, state: State) -> Observation:
        """Returns what the walker senses."""
        return Observation(
            time=state.num_steps * self.timestep,
            torso=state.qpos[EULER],
            torso_rate=state.qvel[EULER],
            angle=state.qpos[JOINTS].reshape(2, 4),
            rate=state.qvel[JOINTS].reshape(2, 4),
            contact=jnp.any(state.touching.reshape(2, 2), axis=1),
            ankle_x=state.ankle_x,
        )

    def hindmost(self, state: State) -> Float[Array, ""]:
        """Returns how far the hindmost ankle has come, m."""
        return state.qpos[0] + jnp.min(state.ankle_x)

    def fitness(self, state: State) -> Float[Array, ""]:
        """Returns the fitness of a walker whose trial has ended, by the paper's figure 4, m."""
        distance = self.hindmost(state)
        in_vain = state.fell & (distance < self.fallen_distance)
        return jnp.where(in_vain, 0.0, distance)

    def step(self, state: State, action: HipTargets, terrain: Terrain) -> State:
        """Returns the walker one physics step later, and whether its trial is over."""
        axes = floating.rotation(state.qpos[EULER])
        data = self._forward(state, axes)
        contacts, loads = self._contacts(state, data, axes, terrain)
        loads |= self._load(state, axes, terrain)
        force, inertia = self._passive_forces(state, axes)
        matrix, right = dynamics.equations(self.floating, data, force, inertia, loads)
        qacc, torque = self._driven(state, action, matrix, right)
        turning = floating.euler_acceleration(state.qpos[EULER], state.qvel[EULER], qacc[EULER])
        qacc = jnp.concatenate([axes @ qacc[:3], turning, qacc[JOINTS]])
        qvel = state.qvel + self.timestep * qacc
        ankles = data.xpos[np.array([self.floating.mujoco.body(foot).id for foot in FEET])]
        centre = axes[2] @ data._impl.cinert[:, 6:9].sum(axis=0) * (GRAVITY / self.weight)
        change = jnp.abs(action.angle - state.target)
        resting = jnp.all(change < self.still_rate * self.timestep)
        moved = state._replace(
            qpos=state.qpos + self.timestep * qvel,
            qvel=qvel,
            stretch=contacts.stretch,
            touching=contacts.touching,
            ankle_x=ankles @ axes[0],
            height=state.qpos[2] + centre - self.terrain.height(terrain, state.qpos[0]),
            target=action.angle,
            still_time=jnp.where(resting, state.still_time + self.timestep, 0.0),
        )
        moved = trial.count(self, moved, touching=contacts.touching, torque=torque, rate=qvel[HIPS])

        def has_fallen(after: State) -> Bool[Array, ""]:
            low = after.height < self.min_height * standing_height(self.offsets)
            return low | (jnp.abs(after.qpos[YAW]) > self.max_yaw)

        after = trial.judge(self, state, moved, max_speed=MAX_SPEED, has_fallen=has_fallen)
        arrived = self.hindmost(after) >= self.max_distance
        return after._replace(done=after.done | arrived | (after.still_time > self.max_still_time))

    @property
    def _ahead(self) -> float:
        """How far implicit springs look ahead, s."""
        return self.timestep if self.integrator == "implicit" else 0.0

    def _forward(self, state: State, axes: Float[Array, "3 3"]) -> Any:
        """Returns positions, velocities and bias forces in the trunk's axes."""
        velocity = state.qvel[:3] @ axes
        spin = floating.spin(state.qpos[EULER], state.qvel[EULER])
        return floating.forward(
            self.floating,
            state.qpos[JOINTS],
            jnp.concatenate([velocity, spin, state.qvel[JOINTS]]),
            -GRAVITY * axes[2],
        )

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
        tilting = jnp.array([1.0, 1.0, 0.0])
        righting = self.assistance * off - damping * spin * tilting
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
