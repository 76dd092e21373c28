"""Spatial biped with powered hips: trunk and two legs of hip, thigh, calf and foot.

Reil & Massey (2001), "Facilitating controller evolution in morpho-functional machines - a bipedal
case study", sections 3 and 4. Each leg has hip roll, hip pitch, knee and ankle; motors drive the
hips' pitch alone, as in section 4.2. Knees swing freely up to a soft knee cap, ankles are damped
springs, and a foot is two spheres. The body is in `reil.xml` and `reil_body.py`.
"""

import dataclasses

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from mjxwalk.envs import checks, edge, floating, trial
from mjxwalk.envs.reil_body import (
    EULER,
    FEET,
    GRAVITY,
    HIPS,
    JOINTS,
    LEG,
    MAX_SPEED,
    SPHERE_RADIUS,
    YAW,
    standing_height,
)
from mjxwalk.envs.reil_physics import ReilPhysics
from mjxwalk.envs.reil_state import HipTargets, Observation, State
from mjxwalk.envs.terrain import Terrain

__all__ = ["HipTargets", "Observation", "Reil", "State"]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Reil(ReilPhysics):
    """The body and the rules of a trial; settings of the body are those of `ReilPhysics`.

    The paper gives sizes, densities and the kinds of joints; all other numbers are ours, and
    docs/reil.md tells how much hangs on each.

    Attributes:
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

    min_height: float = 0.8  # ours: the paper has such a threshold and does not tell it
    max_yaw: float = 1.0  # ours: who turns away from x does not come far
    max_flight_time: float = 0.1  # ours: who flies does not walk; bounces are shorter
    fallen_distance: float = 0.3  # ours: likewise the paper's; less than a step
    still_rate: float = 1e-3  # ours: the paper has the network reach a point
    max_still_time: float = 1.5  # ours: the body has come to rest by then
    min_speed: float = 0.4  # ours: half the paper's average; who stands costs time
    max_lag: float = 1.5  # ours: nearly 4 s to set off
    max_distance: float = 20.0  # section 5: the milestone
    torque_budget: float = 1e6  # ours: the paper has none; more than any trial spends
    max_time: float = 40.0  # ours: 20 m at 0.5 m/s

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.positive(self, "max_distance", "torque_budget", "max_time", "min_height", "max_yaw")
        checks.not_negative(self, "max_flight_time", "fallen_distance", "still_rate")
        checks.not_negative(self, "max_still_time", "min_speed", "max_lag")
        checks.steps(self)

    @edge.takes_arrays
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

    @edge.takes_arrays
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

    @edge.takes_arrays
    def step(self, state: State, action: HipTargets, terrain: Terrain) -> State:
        """Returns the walker one physics step later, and whether its trial is over."""
        axes = floating.rotation(state.qpos[EULER])
        data = self._forward(state, axes)
        contacts, qacc, torque = self._accelerated(state, data, axes, action, terrain)
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
