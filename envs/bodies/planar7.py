"""Planar walker of seven links: upper body, thighs, shanks and feet, after a human of 70 kg.

Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and 3D bipedal
walking over rough terrain", Adaptive Behavior 21(1), doi 10.1177/1059712312462904, sections 2.1 to
2.3. Nine degrees of freedom: the hip's x and z, the upper body's pitch, and hip, knee and ankle of
each leg. Flexion, dorsiflexion and forward lean are positive. The body is in `planar7.xml`, or in a
file of the user's, see `planar7_body.py`.
"""

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import checks, dynamics
from mjxwalk.envs.anatomy import Anatomy
from mjxwalk.envs.bodies import planar7_body
from mjxwalk.envs.bodies.planar7_body import Masses
from mjxwalk.envs.contact import SoftContact
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.legged import LeggedEnv
from mjxwalk.envs.legged_body import Sprung
from mjxwalk.envs.observation import PlanarObservation
from mjxwalk.envs.state import State
from mjxwalk.envs.terrain import RandomWalk
from mjxwalk.envs.trial import Trial, TrialState


@dataclasses.dataclass(frozen=True, kw_only=True)
class Planar7(LeggedEnv):
    """The body, its ground, and the rules of a trial; what all bodies have is in `LeggedEnv`.

    The implicit integrator is stable at 1 ms; the explicit one at 0.2 ms, as in the paper.

    Attributes:
      body: MJCF of a user's body, "" for ours; `mjxwalk.experiments.own_body` takes the masses and
        what depends on lengths from it.
      torso_mass: kg; a link's moment of inertia scales with its mass.
      thigh_mass: kg, each.
      shank_mass: kg, each.
      foot_mass: kg, each.
      start_hip_angle: left hip at the start, rad; the right hip is at minus that.
      min_hip_height: over the ground below, m; under it the walker has fallen.
      max_pitch: of the upper body, rad; beyond it the walker has fallen.
    """

    XML_PATH: ClassVar = planar7_body.MODEL_PATH
    START_DEPARTURES: ClassVar = {
        "hip_angle": 0.05,  # of both legs, rad; ours: a third of the usual angle
        "push": 0.2,  # of the hip forward, m/s; ours: 14 N s for a body of 70 kg, a nudge
        "pitch_rate": 0.3,  # of the upper body, rad/s; ours: as fast as it sways in a good gait
    }

    EXPLICIT_TIMESTEP: ClassVar = 0.0002  # section 2.3

    body: str = dataclasses.field(default="", repr=False)
    torso_mass: float = 47.46
    thigh_mass: float = 7.0
    shank_mass: float = 3.255
    foot_mass: float = 1.015
    terrain: RandomWalk = RandomWalk()
    contact: SoftContact = SoftContact()
    joint_stop: JointStop = JointStop()
    timestep: float = 0.001  # ours: the paper's 0.0002 s is for the explicit integrator
    start_hip_angle: float = 0.15  # ours: staggered feet bootstrap, side by side they lunge
    min_hip_height: float = 0.78  # ours: the paper gives no rule; a lower one lets crouchers win
    max_pitch: float = 1.0  # ours: keeps walkers upright
    max_flight_time: float = 0.002  # flight is a fall, section 2.4; ours: bounces are shorter
    min_speed: float = 0.25  # ours: far below any gait; a walker that stands wins nothing by time
    max_lag: float = 1.0  # ours: 4 s to set off
    torque_budget: float = 28_000.0  # ours: the 3D budget scaled by weight and leg length, times 3
    max_time: float = 30.0  # ours: standing still costs little torque

    def __post_init__(self) -> None:
        checks.positive(self, "torso_mass", "thigh_mass", "shank_mass", "foot_mass")
        checks.positive(self, "min_hip_height", "max_pitch")
        super().__post_init__()
        if self.body:
            planar7_body.check(self.body)
            planar7_body.check_start(self.body, self.start_hip_angle)

    @property
    def model(self) -> dynamics.Model:
        return planar7_body.compile_body(self.body, self.masses)

    @property
    def anatomy(self) -> Anatomy:
        return planar7_body.anatomy(self.body)

    def spec(self) -> Any:
        return planar7_body.with_masses(self.body, self.masses)

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
    def stop_law(self) -> JointStop:
        return self.joint_stop

    @property
    def springs(self) -> Sprung | None:
        return planar7_body.springs(self.body)

    @property
    def max_tilt(self) -> dict[str, float]:
        return {"pitch": self.max_pitch}

    @property
    def lowest_hips(self) -> float:
        return self.min_hip_height

    def start(self, given: Trial, /) -> State:
        """Returns a walker at rest, one leg ahead of the other, soles level on the ground."""
        hip = self.start_hip_angle
        leg, sole = self.leg_length, self.sole_depth
        qpos = jnp.array([0.0, leg * np.cos(hip), 0.0, hip, 0.0, -hip, -hip, 0.0, hip])
        ground = self.terrain.height(given.ground, qpos[0])
        ahead = (leg - sole) * np.sin(hip)
        state = State(
            qpos=qpos.at[1].add(ground - sole * (np.cos(hip) - 1.0)),
            qvel=jnp.zeros(9),
            stretch=jnp.zeros(4),
            touching=jnp.ones(4, bool),
            ankle_x=jnp.array([ahead, -ahead]),
            trial=TrialState.begin(),
        )
        return state if given.start is None else self.depart(state, given.start)

    def depart(self, state: State, draws: Float[Array, " departure"]) -> State:
        """Returns a start of the usual kind as the draws, from -1 to 1, change it."""
        most, usual = self.START_DEPARTURES, self.start_hip_angle
        leg = self.leg_length - self.sole_depth  # m, hip to ankle
        hip = usual + most["hip_angle"] * draws[0]
        x, z, pitch = state.qpos[0], state.qpos[1], state.qpos[2]
        push, pitch_rate = most["push"] * draws[1], most["pitch_rate"] * draws[2]
        rise = leg * (jnp.cos(hip) - np.float32(np.cos(usual)))
        nothing = jnp.zeros(())
        # The feet stay, level, where they are: if both left the ground it would be a fall.
        leg_rate = push / leg
        rates = [pitch_rate - leg_rate, nothing, leg_rate]
        return state._replace(
            qpos=jnp.stack([x, z + rise, pitch, hip, nothing, -hip, -hip, nothing, hip]),
            qvel=jnp.stack([push, nothing, pitch_rate, *rates, *rates]),
            ankle_x=leg * jnp.sin(jnp.stack([hip, -hip])),
        )

    def sense(self, state: State, /) -> PlanarObservation:
        """Returns what the walker senses."""
        return PlanarObservation(
            time=state.trial.num_steps * self.timestep,
            pitch=state.qpos[2],
            pitch_rate=state.qvel[2],
            angle=state.qpos[3:].reshape(2, 3),
            rate=state.qvel[3:].reshape(2, 3),
            contact=jnp.any(state.touching.reshape(2, 2), axis=1),
            ankle_x=state.ankle_x,
        )
