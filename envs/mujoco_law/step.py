"""A step of the physics with MuJoCo's own contacts and constraints."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from mjxwalk.envs import dynamics
from mjxwalk.envs._mujoco import mjx, mujoco
from mjxwalk.envs.motor import Action
from mjxwalk.envs.mujoco_law import coordinates as mujoco_coordinates
from mjxwalk.envs.mujoco_law import forward as mujoco_forward
from mjxwalk.envs.mujoco_law import tree as mujoco_tree
from mjxwalk.envs.mujoco_law.coordinates import Coordinates
from mjxwalk.envs.mujoco_law.forward import NOTHING, Burden, Forward, MujocoState
from mjxwalk.envs.mujoco_law.ground import Ground, level
from mjxwalk.envs.mujoco_law.model import MujocoModel
from mjxwalk.envs.mujoco_law.report import Report, nothing, of_feet

_EULER = int(mujoco.mjtIntegrator.mjINT_EULER)
_RK4 = int(mujoco.mjtIntegrator.mjINT_RK4)
_NO_EULER_DAMPING = int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
# Weights of the classical method of Runge and Kutta: of each slope in the next, and in the sum.
# There is no state after the last.
_NEXT, _SUM = (0.5, 0.5, 1.0, 0.0), (1 / 6, 1 / 3, 1 / 3, 1 / 6)


class _Stage(NamedTuple):
    state: MujocoState
    total: Float[Array, " nv"]  # weighted sum of velocities so far
    gain: Float[Array, " nv"]  # weighted sum of accelerations so far
    told: Any


# Told of one computation of forces, given what was told before and whether it is the step's first.
Tell = Callable[[Any, Forward, Bool[Array, ""]], Any]


def begin(model: MujocoModel, at: Coordinates) -> MujocoState:
    """Returns the state of a body that is somewhere and moves."""
    qpos, qvel = mujoco_coordinates.from_coordinates(model, at)
    return MujocoState(qpos, qvel, jnp.zeros_like(qvel))


def coordinates(model: MujocoModel, state: MujocoState) -> Coordinates:
    """Returns where a body is, in the coordinates of its anatomy, and their rates."""
    return mujoco_coordinates.to_coordinates(model, state.qpos, state.qvel)


def step(
    model: MujocoModel,
    state: MujocoState,
    action: Action,
    ground: Ground = level,
    burden: Burden = NOTHING,
) -> tuple[MujocoState, Report]:
    """Returns the state one step of the model's length later, and what happened in it."""

    def tell(before: Report, now: Forward, is_first: Bool[Array, ""]) -> Report:
        told = of_feet(model, now.data, now.touches, now.solution.force, now.torque)
        return jax.tree.map(lambda new, old: jnp.where(is_first, new, old), told, before)

    return advance(model, state, action, tell, nothing(model), ground, burden)


def advance(
    model: MujocoModel,
    state: MujocoState,
    action: Action,
    tell: Tell,
    told: Any,
    ground: Ground = level,
    burden: Burden = NOTHING,
) -> tuple[MujocoState, Any]:
    """Returns the state one step of the model's length later, and what is told of the way there.

    Args:
      model: of the body.
      state: before the step.
      action: of the motors.
      tell: called with each state that forces are computed of: the first alone, but by the method
        of Runge and Kutta, which goes on to three others.
      told: what `tell` is given at first.
      ground: that is walked on.
      burden: of the torso.
    """

    def forward(state: MujocoState) -> Forward:
        return mujoco_forward.compute(model, state, action, ground, burden)

    if int(model.mujoco.opt.integrator) == _RK4:
        return _runge_kutta(model, state, forward, tell, told)
    now = forward(state)
    found = mujoco_tree.about_root(now.tree, now.solution.qacc)
    matrix, qacc = _implicit(model, now, action), found
    if matrix is not None:
        ending = dynamics.solve(matrix, now.force + now.solution.joint_force)
        qacc = mujoco_tree.about_root(now.tree, ending)
    moved = _advance(model, state.qpos, state.qvel, qacc)
    return MujocoState(*moved, found), tell(told, now, jnp.ones((), bool))


def _implicit(model: MujocoModel, now: Forward, action: Action) -> Float[Array, "nv nv"] | None:
    """Returns the mass matrix with what the integrator takes at the step's end; None if nothing."""
    found, ours = model.mujoco, model.mjx
    timestep = float(found.opt.timestep)
    damping = jnp.asarray(found.dof_damping, now.mass.dtype)
    if int(found.opt.integrator) == _EULER:
        if int(found.opt.disableflags) & _NO_EULER_DAMPING or not found.dof_damping.any():
            return None
        return now.mass + timestep * jnp.diag(damping)
    limited = (now.torque <= model.lowest) | (now.torque >= model.highest)
    damping = damping.at[model.driven].add(jnp.where(limited, 0.0, action.damping))
    matrix = now.mass + timestep * jnp.diag(damping)
    if found.ntendon and found.tendon_damping.any():
        along = now.data._impl.ten_J
        damped = along.T @ (ours.tendon_damping[:, None] * along)
        matrix += timestep * damped * _in_one_branch(found)
    return matrix


def _in_one_branch(found: Any) -> Float[np.ndarray, "nv nv"]:
    """Returns 1 where one degree of freedom moves the other, else 0.

    What a tendon's damper does between branches C MuJoCo takes at the step's begin, as its mass
    matrix has no room for it.
    """
    moves = np.eye(found.nv, dtype=np.float32)
    for dof, parent in enumerate(found.dof_parentid):
        if parent >= 0:
            moves[dof] = np.maximum(moves[dof], moves[parent])
    return np.maximum(moves, moves.T)


def _advance(
    model: MujocoModel,
    qpos: Float[Array, " nq"],
    qvel: Float[Array, " nv"],
    qacc: Float[Array, " nv"],
) -> tuple[Float[Array, " nq"], Float[Array, " nv"]]:
    """Returns positions and velocities after a step with these accelerations."""
    # With its damping off, MJX's integrator does nothing else, and it knows quaternions.
    flags = int(model.mujoco.opt.disableflags) | _NO_EULER_DAMPING
    ours = model.mjx.tree_replace({"opt.disableflags": flags})
    moved = mjx.euler(ours, model.data.replace(qpos=qpos, qvel=qvel, qacc=qacc))
    return moved.qpos, moved.qvel


def _runge_kutta(
    model: MujocoModel,
    state: MujocoState,
    forward: Callable[[MujocoState], Forward],
    tell: Tell,
    told: Any,
) -> tuple[MujocoState, Any]:
    """Returns the state after a step of the classical method of fourth order, and what is told.

    It is a loop, so that engines compile `forward` once.
    """
    timestep = float(model.mujoco.opt.timestep)
    nothing = jnp.zeros_like(state.qvel)

    def stage(at: _Stage, factors: Float[Array, "3"]) -> tuple[_Stage, None]:
        share, weight, is_first = factors
        slope, now = at.state.qvel, forward(at.state)
        qacc = mujoco_tree.about_root(now.tree, now.solution.qacc)
        qpos, _ = _advance(model, state.qpos, share * slope, nothing)
        there = MujocoState(qpos, state.qvel + timestep * share * qacc, qacc)
        told = tell(at.told, now, is_first > 0.0)
        return _Stage(there, at.total + weight * slope, at.gain + weight * qacc, told), None

    factors = jnp.asarray(np.array([_NEXT, _SUM, (1, 0, 0, 0)]).T, state.qvel.dtype)
    end, _ = jax.lax.scan(stage, _Stage(state, nothing, nothing, told), factors)
    qpos, _ = _advance(model, state.qpos, end.total, nothing)
    qvel = state.qvel + timestep * end.gain
    return MujocoState(qpos, qvel, end.state.qacc_warmstart), end.told
