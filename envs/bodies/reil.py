"""Spatial biped with powered hips: trunk and two legs of hip, thigh, calf and foot.

Reil & Massey (2001), "Facilitating controller evolution in morpho-functional machines - a bipedal
case study", sections 3 and 4. Each leg has hip roll, hip pitch, knee and ankle; motors drive the
hips' pitch alone, as in section 4.2. Knees swing freely up to a soft knee cap, ankles are damped
springs, and a foot is two spheres. The body is in `reil.xml` and `reil_body.py`.
"""

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from mjxwalk.envs import checks
from mjxwalk.envs.bodies import reil_body
from mjxwalk.envs.bodies.reil_body import (
    EULER,
    JOINTS,
    LEG,
    SPHERE_RADIUS,
    standing_height,
)
from mjxwalk.envs.bodies.reil_physics import ReilPhysics
from mjxwalk.envs.bodies.reil_state import HipTargets, ReilState
from mjxwalk.envs.ending import Ending
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
from mjxwalk.envs.trees import GRAVITY, Instant
from mjxwalk.envs.trial import Trial, Trials, TrialState


@dataclasses.dataclass(frozen=True, kw_only=True)
class Reil(ReilPhysics):
    """The body, its ground, and the rules of a trial.

    What is the same for all bodies is in `LeggedEnv`; settings of the body are in `ReilPhysics`.

    Attributes:
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
        checks.positive(self, "max_distance", "min_height", "max_yaw")
        checks.not_negative(self, "fallen_distance", "still_rate", "max_still_time")
        super().__post_init__()

    @property
    def max_tilt(self) -> dict[str, float]:
        return {"yaw": self.max_yaw}

    def sample_trials(self, key: PRNGKeyArray, num: int, roughness: float | None = None) -> Trials:
        """Returns independent trials; the ground is a plane, whatever the roughness."""
        del roughness
        return self.equipped(key, self.terrain.sample_trials(key, num))

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

    def carry_on(
        self, state: State, moved: State, now: Instant, action: HipTargets, given: Trial
    ) -> ReilState:
        """Returns the height of the centre of mass, and for how long the hips stood still."""
        assert now.axes is not None  # for the type checker: a tree in space has them
        centre = now.axes[2] @ now.data._impl.cinert[:, 6:9].sum(axis=0)
        ground = self.ground_height(given, state.qpos[0])
        change = jnp.abs(action.target - state.own.target)
        resting = jnp.all(change < self.still_rate * self.timestep)
        del moved
        return ReilState(
            height=state.qpos[2] + centre * (GRAVITY / self.weight) - ground,
            target=action.target,
            still_time=jnp.where(resting, state.own.still_time + self.timestep, 0.0),
        )
