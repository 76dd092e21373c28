"""Any biped of a MJCF file, with settings alone: no code knows the body."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import jax.numpy as jnp

from mjxwalk.envs import body_file, checks, dynamics, mjcf_body
from mjxwalk.envs.anatomy import Anatomy
from mjxwalk.envs.contact import SoftContact
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.legged import LeggedEnv
from mjxwalk.envs.legged_body import Sprung
from mjxwalk.envs.observation import PlanarObservation, SpatialObservation
from mjxwalk.envs.state import State
from mjxwalk.envs.surface import SerpentineWalk
from mjxwalk.envs.trial import Trial, TrialState


@dataclasses.dataclass(frozen=True, kw_only=True)
class MjcfEnv(LeggedEnv):
    """The body of a file, its ground, and the rules of a trial.

    What all bodies have is in `LeggedEnv`; what a file has to hold is in `mjcf_body.py`.

    Attributes:
      body: MJCF.
      start_angles: of the joints by name at the start, rad; the others are zero.
      min_height: of the root over the ground, as a share of that at the start; under it the walker
        has fallen.
      max_pitch: of the torso, rad; beyond it the walker has fallen.
      max_roll: of the torso, rad; beyond it the walker has fallen.
      max_yaw: of the torso, rad; beyond it the walker has fallen.
      joint_stop: law of the joints' limits.
    """

    body: str = dataclasses.field(repr=False)
    terrain: Any = SerpentineWalk()
    contact: SoftContact = SoftContact(stiffness=12_500.0, damping=625.0)  # ours: of some 10 kg
    joint_stop: JointStop = JointStop(stiffness=1_000.0, damping=10.0)  # ours: of some 10 kg
    # A table cannot be hashed; settings that differ in it alone may share a hash.
    start_angles: Mapping[str, float] = dataclasses.field(
        default_factory=dict[str, float], hash=False
    )
    timestep: float = 0.001  # ours
    min_height: float = 0.75  # ours: a lower one lets crouchers win
    max_pitch: float = 1.0  # ours
    max_roll: float = 1.0  # ours
    max_yaw: float = 1.2  # ours: a walker that turns away from x does not come far
    max_flight_time: float = 0.1  # ours: a walker that flies does not walk
    min_speed: float = 0.1  # ours: far below any gait
    max_lag: float = 1.0  # ours: 10 s to set off
    torque_budget: float = 1e6  # ours: more than any trial spends
    max_time: float = 30.0  # ours

    def __post_init__(self) -> None:
        checks.positive(self, "min_height", "max_pitch", "max_roll", "max_yaw")
        super().__post_init__()
        _ = self._stance  # refuses a file that is no body

    @property
    def model(self) -> dynamics.Model:
        return mjcf_body.hinged_model(self.body)

    @property
    def floating(self) -> dynamics.Model | None:
        return mjcf_body.floating_model(self.body)

    @property
    def anatomy(self) -> Anatomy:
        return mjcf_body.anatomy(self.body)

    def spec(self) -> Any:
        return body_file.read(self.body)

    @property
    def stop_law(self) -> JointStop:
        return self.joint_stop

    @property
    def springs(self) -> Sprung | None:
        return mjcf_body.springs(self.body)

    @property
    def max_tilt(self) -> dict[str, float]:
        limits = {"yaw": self.max_yaw, "pitch": self.max_pitch, "roll": self.max_roll}
        root = self.anatomy.root
        return {turn: most for turn, most in limits.items() if getattr(root, turn) is not None}

    @property
    def lowest_hips(self) -> float:
        return self.min_height * float(self._stance.qpos[self.anatomy.root.height])

    def start(self, given: Trial, /) -> State:
        """Returns a walker at rest, its lowest points as deep as its weight presses them."""
        stance, root = self._stance, self.anatomy.root
        depth = self.weight / (int(stance.touching.sum()) * self.contact.stiffness)
        zero = jnp.zeros(())
        ground = self.terrain.height(given.ground, zero, None if root.is_planar else zero)
        points = len(self.anatomy.points)
        return State(
            qpos=jnp.asarray(stance.qpos).at[root.height].add(ground - depth),
            qvel=jnp.zeros(len(stance.qpos)),
            stretch=jnp.zeros(points if root.is_planar else (points, 2)),
            touching=jnp.asarray(stance.touching),
            ankle_x=jnp.asarray(stance.ankle_x),
            trial=TrialState.begin(),
        )

    def sense(self, state: State, /) -> PlanarObservation | SpatialObservation:
        """Returns what the walker senses."""
        anatomy, root = self.anatomy, self.anatomy.root
        of_legs = {
            "time": state.trial.num_steps * self.timestep,
            "angle": state.qpos[root.num :].reshape(2, -1),
            "rate": state.qvel[root.num :].reshape(2, -1),
            "contact": jnp.stack(
                [jnp.any(state.touching[jnp.array(anatomy.points_of(leg))]) for leg in anatomy.legs]
            ),
            "ankle_x": state.ankle_x,
        }
        if root.is_planar:
            pitch, rate = state.qpos[root.pitch], state.qvel[root.pitch]
            return PlanarObservation(pitch=pitch, pitch_rate=rate, **of_legs)
        return SpatialObservation(
            torso=state.qpos[3:6],
            torso_rate=state.qvel[3:6],
            adduction=None,
            adduction_rate=None,
            **of_legs,
        )

    @property
    def _stance(self) -> mjcf_body.Stance:
        return mjcf_body.stance(self.body, tuple(sorted(self.start_angles.items())))
