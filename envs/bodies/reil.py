"""Spatial biped with powered hips: trunk and two legs of hip, thigh, calf and foot.

Reil & Massey (2001), "Facilitating controller evolution in morpho-functional machines - a bipedal
case study", sections 3 and 4. Each leg has hip roll, hip pitch, knee and ankle; motors drive the
hips' pitch alone, as in section 4.2. Knees swing freely up to a soft knee cap, ankles are damped
springs, and a foot is two spheres. The body is in `reil.xml` and `reil_body.py`.
"""

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from mjxwalk.envs import checks, dynamics, floating, motor
from mjxwalk.envs.anatomy import Anatomy
from mjxwalk.envs.bodies import reil_body
from mjxwalk.envs.bodies.reil_body import (
    EULER,
    HIPS,
    JOINTS,
    LEG,
    NUM_COORDINATES,
    SPHERE_RADIUS,
    Offsets,
    standing_height,
)
from mjxwalk.envs.bodies.reil_state import HipTargets, ReilState
from mjxwalk.envs.bodies.reil_trials import TrialVariation
from mjxwalk.envs.contact import SoftContact
from mjxwalk.envs.ending import Ending
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.legged import Driven, LeggedEnv, Sprung
from mjxwalk.envs.observation import SpatialObservation
from mjxwalk.envs.own_laws import (
    Arrival,
    HindmostAnkle,
    LowCentre,
    Righting,
    Standstill,
    TorsoLoad,
)
from mjxwalk.envs.state import State
from mjxwalk.envs.trees import GRAVITY, Instant, Loads
from mjxwalk.envs.trial import Trial, Trials, TrialState
from mjxwalk.envs.velocity_motor import VelocityMotor


@dataclasses.dataclass(frozen=True, kw_only=True)
class Reil(LeggedEnv):
    """The body, its ground, and the rules of a trial; what all bodies have is in `LeggedEnv`.

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
      min_height: of the centre of mass over the ground, as a share of that when standing; under it
        the walker has fallen.
      max_yaw: rad; beyond it the walker counts as fallen.
      fallen_distance: a walker that falls before its hindmost foot is that far has fitness 0, m.
      still_rate: desired angles that change slower than this stand still, rad/s.
      max_still_time: the trial ends when they have for so long, s.
      max_distance: the trial ends when the hindmost foot is there, m.
    """

    XML_PATH: ClassVar = reil_body.MODEL_PATH
    # ours: a push that tips a straight body by a degree in 0.2 s, and half a foot's length of
    # stride. What trials draw is otherwise a setting of their own, `terrain`.
    START_DEPARTURES: ClassVar = {
        "push": 0.1,
        "sideways": 0.05,
        "pitch_rate": 0.1,
        "stride": 0.05,
    }

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
    min_height: float = 0.8  # ours: the paper has such a threshold and does not tell it
    # ours: fitness is distance along x, so a walker that turns away is stopped early
    max_yaw: float = 1.0
    max_flight_time: float = 0.1  # ours: a walker that flies does not walk; bounces are shorter
    fallen_distance: float = 0.3  # ours: the paper does not tell its own; less than a step
    still_rate: float = 1e-3  # ours: the paper has the network reach a point
    max_still_time: float = 1.5  # ours: the body has come to rest by then
    min_speed: float = 0.4  # ours: half the paper's average; a walker that stands costs time
    max_lag: float = 1.5  # ours: nearly 4 s to set off
    max_distance: float = 20.0  # section 5: the milestone
    torque_budget: float = 1e6  # ours: the paper has none; more than any trial spends
    max_time: float = 40.0  # ours: 20 m at 0.5 m/s

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
        checks.positive(self, "max_distance", "min_height", "max_yaw")
        checks.not_negative(self, "fallen_distance", "still_rate", "max_still_time")
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
        return Sprung(np.array([0, 2, 3, 4, 6, 7]), motor.Springs(*columns))

    @property
    def max_tilt(self) -> dict[str, float]:
        return {"yaw": self.max_yaw}

    def sample_trials(self, key: PRNGKeyArray, num: int, roughness: float | None = None) -> Trials:
        """Returns independent trials; the ground is a plane, whatever the roughness."""
        del roughness
        return self.terrain.sample_trials(key, num)

    def perturbed(self, key: PRNGKeyArray, trials: Trials) -> tuple["Reil", Trials]:
        """Returns the environment whose trials depart from the usual start as they have drawn."""
        del key
        terrain = dataclasses.replace(self.terrain, **self.START_DEPARTURES)
        return dataclasses.replace(self, terrain=terrain), trials

    def start(self, given: Trial, /) -> State:
        """Returns a walker that stands straight, or moves already as its trial has it.

        The soles are as deep in the ground as the weight presses them; of a body astride, or on a
        slope, the ankles are.
        """
        push, sideways, pitch_rate, stride = self.terrain.departures(given.start)
        reach = LEG + self.sole + SPHERE_RADIUS
        leg_rate = push / (LEG * jnp.cos(stride))
        depth = self.weight / (4.0 * self.contact.stiffness)
        drop = self.sole + SPHERE_RADIUS
        nothing = jnp.zeros(())
        angles = [nothing, stride, nothing, -stride, nothing, -stride, nothing, stride]
        rates = [nothing, pitch_rate - leg_rate, nothing, leg_rate] * 2
        height = LEG * jnp.cos(stride) + drop - depth
        tip = -sideways / reach
        root = [nothing, nothing, height, nothing, nothing, nothing]
        root_rate = [push, sideways, nothing, nothing, pitch_rate, tip]
        ahead = LEG * jnp.sin(stride)
        return State(
            qpos=jnp.stack(root + angles),
            qvel=jnp.stack(root_rate + rates),
            stretch=jnp.zeros((4, 2)),
            touching=jnp.ones(4, bool),
            ankle_x=jnp.stack([ahead, -ahead]),
            trial=TrialState.begin(),
            own=ReilState(
                height=jnp.full((), standing_height(self.offsets)),
                target=jnp.zeros(2),
                still_time=nothing,
            ),
        )

    def sense(self, state: State, /) -> SpatialObservation:
        """Returns what the walker senses."""
        return SpatialObservation(
            time=state.trial.num_steps * self.timestep,
            torso=state.qpos[EULER],
            torso_rate=state.qvel[EULER],
            adduction=None,
            adduction_rate=None,
            angle=state.qpos[JOINTS].reshape(2, 4),
            rate=state.qvel[JOINTS].reshape(2, 4),
            contact=jnp.any(state.touching.reshape(2, 2), axis=1),
            ankle_x=state.ankle_x,
        )

    def hindmost(self, state: State) -> Float[Array, ""]:
        """Returns how far the hindmost ankle has come, m."""
        return state.qpos[0] + jnp.min(state.ankle_x)

    def fitness(self, state: State, /) -> Float[Array, ""]:
        """Returns the fitness of a walker whose trial has ended, by the paper's figure 4, m."""
        distance = self.hindmost(state)
        in_vain = state.trial.fell & (distance < self.fallen_distance)
        return jnp.where(in_vain, 0.0, distance)

    def is_low(self, state: State, ground: Float[Array, ""] | float, /) -> Bool[Array, ""]:
        """Returns whether the centre of mass is too low."""
        del ground  # the height is over it
        return state.own.height < self.min_height * standing_height(self.offsets)

    def low_words(self) -> str:
        """Returns what `is_low` means."""
        return f"centre of mass lower than {self.min_height:.0%} of standing"

    def is_over(self, state: State, /) -> Bool[Array, ""]:
        """Returns whether the walker has arrived, or its hips are asked to stand still."""
        arrived = self.hindmost(state) >= self.max_distance
        return arrived | (state.own.still_time > self.max_still_time)

    def over_words(self, state: State, /) -> Ending | None:
        """Returns which of the two ended a trial; None if neither did."""
        if float(self.hindmost(state)) >= self.max_distance:
            return Ending("time", f"came to {self.max_distance:g} m, where trials end")
        if float(state.own.still_time) > self.max_still_time:
            return Ending("slow", "its hips were asked to stand still")
        return None

    def own_laws(self) -> dict[str, tuple[Any, ...]]:
        righting = self.assistance, self.assistance_damping, self.assistance_lean
        return {
            "drive": (self.hips, Righting(*righting, self.assistance_roll)),
            "carried": (TorsoLoad(self.terrain.load, (0.0, 0.0, self.trunk_height)),),
            "is_low": (LowCentre(self.min_height),),
            "is_over": (
                Arrival(self.max_distance),
                Standstill(self.still_rate, self.max_still_time),
            ),
            "fitness": (HindmostAnkle(self.fallen_distance),),
        }

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

    def carry_on(
        self, state: State, moved: State, now: Instant, action: HipTargets, given: Trial
    ) -> ReilState:
        """Returns the height of the centre of mass, and for how long the hips stood still."""
        assert now.axes is not None  # for the type checker: a tree in space has them
        centre = now.axes[2] @ now.data._impl.cinert[:, 6:9].sum(axis=0)
        ground = self.terrain.height(given.ground, state.qpos[0])
        change = jnp.abs(action.target - state.own.target)
        resting = jnp.all(change < self.still_rate * self.timestep)
        del moved
        return ReilState(
            height=state.qpos[2] + centre * (GRAVITY / self.weight) - ground,
            target=action.target,
            still_time=jnp.where(resting, state.own.still_time + self.timestep, 0.0),
        )

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
