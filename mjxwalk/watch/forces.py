"""What motors and ground do to a walker in each frame of a recording."""

import dataclasses
import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk import engines
from mjxwalk.engines import lanes, mjx
from mjxwalk.envs import Reil, Terrain, dynamics, motor
from mjxwalk.envs.reil_body import SPHERE_RADIUS
from mjxwalk.replay import Recording
from mjxwalk.rollout import Controller
from mjxwalk.watch import bodies


class Forces(NamedTuple):
    """Forces on one walker, in a frame or in many.

    Attributes:
      torque: of the motors, N m, in the order of an action.
      ground: on the points of the feet, N, in the order of `Layout.points`; x, y and z.
    """

    torque: Float[Any, "*frame motor"]
    ground: Float[Any, "*frame point 3"]


def measure(
    env: Any, controller: Controller, genotype: Any, terrain: Any, recording: Recording, walker: int
) -> Forces:
    """Returns the forces on one of the walkers in all frames; numpy.

    Args:
      env: that the recording is of.
      controller: likewise.
      genotype: of the one walker.
      terrain: that all walkers were recorded on.
      recording: with memories.
      walker: its place in it.
    """
    states, memories = (
        jax.tree.map(lambda leaf: np.ascontiguousarray(leaf[:, walker]), each)
        for each in (recording.states, recording.memories)
    )
    mapped = _compiled(_Walker(env, controller), engines.choose("auto").name)
    found = mapped(states, memories, genotype, terrain.heights, np.int32(terrain.row[walker]))
    return jax.tree.map(np.asarray, found)


@dataclasses.dataclass(frozen=True)
class _Walker:
    """A body and what drives it: the settings of the function that engines compile."""

    env: Any
    controller: Controller

    def forces(self, state: Any, memory: Any, genotype: Any, heights: Any, row: Any) -> Forces:
        """Returns the forces on a walker in a state."""
        _, action = self.controller.act(genotype, memory, self.env.observe(state))
        terrain = Terrain(heights, row)
        torque = _torques(self.env, state, action, terrain)
        return Forces(torque, ground_forces(self.env, state, terrain))


@functools.lru_cache(maxsize=8)
def _compiled(walker: _Walker, engine: str) -> Any:
    axes = (0, 0, None, None, None)
    if engine == "lanes":
        return lanes.vmap(walker.forces, axes, results=Forces(torque=0, ground=1))
    return (lanes.xla_vmap if engine == "lanes-xla" else mjx.vmap)(walker.forces, axes)


def _torques(env: Any, state: Any, action: Any, terrain: Terrain) -> Float[Array, " motor"]:
    if isinstance(env, Reil):
        return env.motor_torque(state, action, terrain)
    driven = np.array(bodies.layout(env).motors)
    return motor.driven(
        action, state.qpos[driven], state.qvel[driven], env.limits, ahead=0.0
    ).torque


def ground_forces(env: Any, state: Any, terrain: Terrain) -> Float[Array, "point 3"]:
    """Returns the ground's force on each point of the feet, N, by its law in this state.

    Steps take the law implicitly; what they apply is this, up to what a step changes.
    """
    where = bodies.layout(env)
    joints = np.array(where.coordinate)
    data = dynamics.forward(env.model, state.qpos[joints], state.qvel[joints])
    model = env.model.mujoco
    found: list[Array] = []
    # A sphere touches the ground with its lowest point, whatever way the foot is turned.
    below = np.array([0.0, 0.0, SPHERE_RADIUS if isinstance(env, Reil) else 0.0], np.float32)
    for name, stretch in zip(where.points, state.stretch, strict=True):
        site = model.site(name).id
        point = data.site_xpos[site] - below
        velocity = dynamics.point_velocity(
            data, int(model.site_bodyid[site]), dynamics.point_offset(data, point)
        )
        in_space = stretch.ndim == 1
        across = slice(0, 2 if in_space else 1)
        contact = env.contact.force(
            env.terrain.height(terrain, *point[across]) - point[2],
            (velocity[across] if in_space else velocity[0], velocity[2]),
            stretch,
            timestep=0.0,
            implicit=False,
        )
        along = contact.tangential if in_space else jnp.stack([contact.tangential, jnp.zeros(())])
        found.append(jnp.append(along, contact.normal))
    return jnp.stack(found)
