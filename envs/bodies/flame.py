"""Spatial walker of nine links after the robot Flame: a torso and two legs of four links.

Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and 3D bipedal
walking over rough terrain", Adaptive Behavior 21(1), doi 10.1177/1059712312462904, sections 2.1 and
3.5. The body is in `flame.xml` and `flame_body.py`, or in a file of the user's.
"""

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.envs import checks, dynamics
from mjxwalk.envs.anatomy import Anatomy
from mjxwalk.envs.bodies import flame_body
from mjxwalk.envs.bodies.flame_body import ADDUCTION, EULER, PITCH, ROLL
from mjxwalk.envs.contact import SoftContact
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.legged import LeggedEnv
from mjxwalk.envs.legged_body import Sprung
from mjxwalk.envs.observation import SpatialObservation
from mjxwalk.envs.own_laws import AlongHeading
from mjxwalk.envs.state import State
from mjxwalk.envs.surface import SerpentineWalk
from mjxwalk.envs.trees import Instant
from mjxwalk.envs.trial import Trial, TrialState


@dataclasses.dataclass(frozen=True, kw_only=True)
class Flame(LeggedEnv):
    """The body, its ground, and the rules of a trial; what all bodies have is in `LeggedEnv`.

    The implicit integrator is stable at 1 ms; the explicit one needs 0.02 ms.

    Attributes:
      body: MJCF of a user's body, "" for ours; `mjxwalk.experiments.own_body` takes what depends on
        its size from it.
      ankle_roll_stiffness: of the passive spring, N m/rad.
      ankle_roll_damping: of the passive damper, N m s/rad.
      min_hip_height: over the ground below, m; under it the walker has fallen.
      max_pitch: of the torso, rad; beyond it the walker has fallen.
      max_roll: of the torso, rad; beyond it the walker has fallen.
      max_yaw: of the torso, rad; beyond it the walker has fallen.
    """

    XML_PATH: ClassVar = flame_body.MODEL_PATH
    START_DEPARTURES: ClassVar = {
        "swing_hip": 0.1,  # of its angle, rad; ours: a quarter of the usual one
        "push": 0.05,  # of the hip sideways, m/s; ours: some degrees of roll before the next step
        "pitch_rate": 0.3,  # of the torso, rad/s; ours: as in the plane
    }

    body: str = dataclasses.field(default="", repr=False)
    terrain: SerpentineWalk = SerpentineWalk()
    # A quarter each of the foot's 50,000 N/m and 2,500 N s/m, section 2.3.
    contact: SoftContact = SoftContact(stiffness=12_500.0, damping=625.0)
    joint_stop: JointStop = JointStop(stiffness=1_000.0, damping=10.0)  # ours: see JointStop
    ankle_roll_stiffness: float = 10.0  # ours: not given
    ankle_roll_damping: float = 0.2  # ours: not given
    timestep: float = 0.001  # section 2.3
    min_hip_height: float = 0.555  # ours: the paper gives no rule; a lower one lets crouchers win
    max_pitch: float = 0.5  # ours: keeps walkers upright
    max_roll: float = 0.7  # ours
    # ours: fitness is distance along x, so a walker that turns away is stopped early
    max_yaw: float = 1.2
    max_flight_time: float = 0.01  # flight is a fall, section 2.4; ours: bounces are shorter
    min_speed: float = 0.25  # ours: far below any gait; a walker that stands wins nothing by time
    max_lag: float = 1.0  # ours: 4 s to set off
    torque_budget: float = 1_000.0  # section 3.5.1
    max_time: float = 60.0  # ours: standing still costs little torque

    def __post_init__(self) -> None:
        checks.positive(self, "min_hip_height", "max_pitch", "max_roll", "max_yaw")
        checks.not_negative(self, "ankle_roll_stiffness", "ankle_roll_damping")
        super().__post_init__()
        if self.body:
            flame_body.check(self.body)

    @property
    def model(self) -> dynamics.Model:
        return flame_body.hinged_model(self.body)

    @property
    def floating(self) -> dynamics.Model:
        return flame_body.floating_model(self.body)

    @property
    def anatomy(self) -> Anatomy:
        return flame_body.anatomy(self.body)

    def spec(self) -> Any:
        return flame_body.whole_spec(self.body, self.ankle_roll_stiffness, self.ankle_roll_damping)

    @property
    def leg_length(self) -> float:
        """Hip to floor with the leg straight, m."""
        return flame_body.leg_length(self.body)

    @property
    def stop_law(self) -> JointStop:
        return self.joint_stop

    @property
    def springs(self) -> Sprung:
        roll = self.ankle_roll_stiffness, self.ankle_roll_damping
        return flame_body.springs(self.body, roll)

    @property
    def max_tilt(self) -> dict[str, float]:
        return {"yaw": self.max_yaw, "pitch": self.max_pitch, "roll": self.max_roll}

    @property
    def lowest_hips(self) -> float:
        return self.min_hip_height

    def start(self, given: Trial, /) -> State:
        """Returns a walker in the middle of a step, the left foot in the air."""
        depth = self.weight / (4.0 * self.contact.stiffness)
        qpos, qvel, ankle_x = flame_body.start(self.body, depth)
        ground = self.terrain.height(given.ground, jnp.zeros(()), jnp.zeros(()))
        state = State(
            qpos=jnp.asarray(qpos).at[2].add(ground),
            qvel=jnp.asarray(qvel),
            stretch=jnp.zeros((8, 2)),
            touching=jnp.arange(8) >= 4,
            ankle_x=jnp.asarray(ankle_x),
            trial=TrialState.begin(),
        )
        return state if given.start is None else self.depart(state, given.start)

    def depart(self, state: State, draws: Float[Array, " departure"]) -> State:
        """Returns a start of the usual kind as the draws, from -1 to 1, change it.

        The walker tips about its stance foot with the push; the thighs keep their rate.
        """
        most, (left_hip, right_hip) = self.START_DEPARTURES, flame_body.HIPS
        push, pitch_rate = most["push"] * draws[1], most["pitch_rate"] * draws[2]
        qvel = state.qvel.at[1].add(push).at[ROLL].add(-push / self.leg_length)
        for turns in (PITCH, left_hip, right_hip):
            qvel = qvel.at[turns].add(pitch_rate)
        return state._replace(
            qpos=state.qpos.at[left_hip].add(most["swing_hip"] * draws[0]), qvel=qvel
        )

    def sense(self, state: State, /) -> SpatialObservation:
        """Returns what the walker senses."""
        return SpatialObservation(
            time=state.trial.num_steps * self.timestep,
            torso=state.qpos[EULER],
            torso_rate=state.qvel[EULER],
            adduction=state.qpos[ADDUCTION],
            adduction_rate=state.qvel[ADDUCTION],
            angle=state.qpos[ADDUCTION + 1 :].reshape(2, 4),
            rate=state.qvel[ADDUCTION + 1 :].reshape(2, 4),
            contact=jnp.any(state.touching.reshape(2, 4), axis=1),
            ankle_x=state.ankle_x,
        )

    def ankles(self, state: State, now: Instant, /) -> Float[Array, " leg"]:
        """Returns how far each ankle is ahead of the hip, m: where the torso heads."""
        # Seen along the torso's pitch, the heading is level.
        cosine, sine = jnp.cos(state.qpos[PITCH]), jnp.sin(state.qpos[PITCH])
        ahead = jnp.stack(
            [cosine, sine * jnp.sin(state.qpos[ROLL]), sine * jnp.cos(state.qpos[ROLL])]
        )
        return self._tree.bodies(now, self._feet) @ ahead

    def own_laws(self) -> dict[str, tuple[Any, ...]]:
        return {"ankles": (AlongHeading(),)}
