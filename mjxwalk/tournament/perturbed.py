"""Trials that start in another state than those of the evolution: pushed, swinging, legs astride.

A walker that only repeats a start by heart falls. What is drawn for a trial lies at the end of its
terrain's row, where the ground does not look: so every engine hands it to the walker unchanged.
"""

import dataclasses
from typing import Any, overload

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.envs import Flame, Planar7, Reil, State, Terrain, flame, flame_body

DRAWS = 3  # for each trial, one for each number that is perturbed


@dataclasses.dataclass(frozen=True, kw_only=True)
class Perturbation:
    """How far a start may be from the usual one, to either side; all between is equally likely.

    Attributes:
      hip_angle: of both legs from the vertical, rad.
      push: of the hip, forward or back; the legs turn about the feet with it, m/s.
      pitch_rate: of the upper body, rad/s.
    """

    hip_angle: float = 0.05  # ours: a third of the usual, so that the first step is that much off
    push: float = 0.2  # ours: 14 N s for a body of 70 kg, a nudge
    pitch_rate: float = 0.3  # ours: as fast as the upper body sways in a good gait


@dataclasses.dataclass(frozen=True, kw_only=True)
class PerturbedPlanar7(Planar7):
    """The planar walker, whose trials start where the draws behind its terrain put it.

    Attributes:
      perturbation: how far from the usual start.
    """

    perturbation: Perturbation = Perturbation()

    def reset(self, terrain: Terrain) -> State:
        """Returns a walker that moves already, soles level on the ground."""
        return self.perturb(super().reset(terrain), _drawn(terrain))

    def perturb(self, state: State, draws: Float[Array, " draw"]) -> State:
        """Returns a start of the usual kind as the draws, from -1 to 1, change it."""
        most, usual = self.perturbation, self.start_hip_angle
        leg = self.leg_length - self.sole_depth  # m, hip to ankle
        hip = usual + most.hip_angle * draws[0]
        x, z, pitch = state.qpos[0], state.qpos[1], state.qpos[2]
        push, pitch_rate = most.push * draws[1], most.pitch_rate * draws[2]
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


@dataclasses.dataclass(frozen=True, kw_only=True)
class SpatialPerturbation:
    """How far a start may be from the usual one, to either side; all between is equally likely.

    Attributes:
      swing_hip: of the swing hip's angle, rad.
      push: of the hip, sideways; the walker tips about its stance foot with it, m/s.
      pitch_rate: of the torso, rad/s; the thighs keep theirs.
    """

    swing_hip: float = 0.1  # ours: a quarter of the usual angle
    push: float = 0.05  # ours: some degrees of roll before the next step
    pitch_rate: float = 0.3  # ours: as in the plane


@dataclasses.dataclass(frozen=True, kw_only=True)
class PerturbedFlame(Flame):
    """The spatial walker, whose trials start where the draws behind its terrain put it.

    Attributes:
      perturbation: how far from the usual start.
    """

    perturbation: SpatialPerturbation = SpatialPerturbation()

    def reset(self, terrain: Terrain) -> flame.State:
        """Returns a walker in the middle of another step."""
        return self.perturb(super().reset(terrain), _drawn(terrain))

    def perturb(self, state: flame.State, draws: Float[Array, " draw"]) -> flame.State:
        """Returns a start of the usual kind as the draws, from -1 to 1, change it."""
        most = self.perturbation
        left_hip, right_hip = flame_body.HIPS
        push, pitch_rate = most.push * draws[1], most.pitch_rate * draws[2]
        qvel = state.qvel.at[1].add(push).at[flame_body.ROLL].add(-push / self.leg_length)
        for turns in (flame_body.PITCH, left_hip, right_hip):
            qvel = qvel.at[turns].add(pitch_rate)
        return state._replace(
            qpos=state.qpos.at[left_hip].add(most.swing_hip * draws[0]), qvel=qvel
        )


# How far a start of `Reil` may be from the usual one, to either side; it draws its trials itself.
# ours: a push that tips a straight body by a degree in 0.2 s, and half a foot's length of stride.
REIL_STARTS = {"push": 0.1, "sideways": 0.05, "pitch_rate": 0.1, "stride": 0.05}


@overload
def perturbed(env: Planar7) -> PerturbedPlanar7: ...
@overload
def perturbed(env: Flame) -> PerturbedFlame: ...
@overload
def perturbed(env: Reil) -> Reil: ...
def perturbed(env: Planar7 | Flame | Reil) -> PerturbedPlanar7 | PerturbedFlame | Reil:
    """Returns the same body and rules with perturbed starts."""
    if isinstance(env, Reil):
        return dataclasses.replace(env, terrain=dataclasses.replace(env.terrain, **REIL_STARTS))
    kind = PerturbedFlame if isinstance(env, Flame) else PerturbedPlanar7
    settings: Any = {f.name: getattr(env, f.name) for f in dataclasses.fields(env)}
    return kind(**settings)


def with_draws(
    key: PRNGKeyArray, heights: Float[Array, "terrain along *across"]
) -> Float[Array, "terrain longer *across"]:
    """Returns the terrains, each with the draws of its trial's start behind its last node."""
    num, _, *across = heights.shape
    draws = jax.random.uniform(key, (num, DRAWS), minval=-1.0, maxval=1.0)
    if across:
        draws = jnp.pad(draws, ((0, 0), (0, across[0] - DRAWS)))[:, None]
    return jnp.concatenate([heights, draws], axis=1)


def _drawn(terrain: Terrain) -> Float[Array, " draw"]:
    """Returns the draws of a walker's start."""
    _, along, *across = terrain.heights.shape
    if across:
        place, size = (terrain.row, along - 1, 0), (1, 1, DRAWS)
    else:
        place, size = (terrain.row, along - DRAWS), (1, DRAWS)
    return jax.lax.dynamic_slice(terrain.heights, place, size).ravel()
