"""A step of the physics with MuJoCo's own contacts and constraints."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import dynamics, motor
from mjxwalk.envs._mujoco import mjx, mujoco
from mjxwalk.envs.motor import Action, Limits
from mjxwalk.envs.mujoco_law import coordinates as mujoco_coordinates
from mjxwalk.envs.mujoco_law import ground as mujoco_ground
from mjxwalk.envs.mujoco_law import rows as contact_rows
from mjxwalk.envs.mujoco_law import solver, ties
from mjxwalk.envs.mujoco_law.coordinates import Coordinates
from mjxwalk.envs.mujoco_law.ground import Ground, Touches, level
from mjxwalk.envs.mujoco_law.model import MujocoModel
from mjxwalk.envs.mujoco_law.report import Report, of_feet
from mjxwalk.envs.mujoco_law.solver import Cones, Rows, Solution

_PYRAMIDAL = int(mujoco.mjtCone.mjCONE_PYRAMIDAL)
_EULER = int(mujoco.mjtIntegrator.mjINT_EULER)
_RK4 = int(mujoco.mjtIntegrator.mjINT_RK4)
_NO_EULER_DAMPING = int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
TORSO = 1  # number of the body that carries the others
# Weights of the classical method of Runge and Kutta: of each slope in the next, and in the sum.
_NEXT, _SUM = (0.5, 0.5, 1.0), (1 / 6, 1 / 3, 1 / 3, 1 / 6)


class MujocoState(NamedTuple):
    """What MuJoCo carries from one step to the next.

    Attributes:
      qpos: positions, a free root's attitude as a quaternion.
      qvel: velocities.
      qacc_warmstart: accelerations of the last step, near which the solver looks.
    """

    qpos: Float[Array, " nq"]
    qvel: Float[Array, " nv"]
    qacc_warmstart: Float[Array, " nv"]


class Burden(NamedTuple):
    """What a trial puts on the torso, which is body 1; by default nothing.

    Attributes:
      load: point mass that it carries; constraints are as soft as without it.
      push: force on its own centre of mass, world axes, N.
    """

    load: dynamics.PointMass | None = None
    push: Float[Array, "3"] | None = None


NOTHING = Burden()


class _Forward(NamedTuple):
    data: Any
    mass: Float[Array, "nv nv"]
    force: Float[Array, " nv"]
    solution: Solution
    touches: tuple[Touches, ...]
    torque: Float[Array, " motor"]


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

    def forward(state: MujocoState) -> _Forward:
        return _forward(model, state, action, ground, burden)

    now = forward(state)
    integrator = int(model.mujoco.opt.integrator)
    if integrator == _RK4:
        moved = _runge_kutta(model, state, forward, now)
    else:
        qacc = now.solution.qacc
        matrix = _implicit(model, now, action)
        if matrix is not None:
            qacc = dynamics.solve(matrix, now.force + now.solution.joint_force)
        moved = _advance(model, now.data, state.qpos, state.qvel, qacc)
    report = of_feet(model, now.data, now.touches, now.solution.force, now.torque)
    return MujocoState(*moved, now.solution.qacc), report


def _forward(
    model: MujocoModel, state: MujocoState, action: Action, ground: Ground, burden: Burden
) -> _Forward:
    """Returns accelerations, and all that they came of."""
    ours = model.mjx
    data = model.data.replace(qpos=state.qpos, qvel=state.qvel)
    data = mjx.fwd_position(ours, data)
    if burden.load is not None:
        data = dynamics.with_mass(data, burden.load)
        data = mjx.tendon_armature(ours, mjx.crb(ours, data))
    data = mjx.fwd_velocity(ours, data)
    limits = Limits(model.lowest, model.highest)
    joints = model.driven + (state.qpos.shape[0] - state.qvel.shape[0])
    torque = motor.driven(
        action, state.qpos[joints], state.qvel[model.driven], limits, ahead=0.0
    ).torque
    force = data.qfrc_passive - data.qfrc_bias
    force = force.at[model.driven].add(torque)
    if burden.push is not None:
        force += _pushed(model, data, burden.push)
    mass = mjx.full_m(ours, data)
    rows, touches = _rows(model, data, ground)
    option = model.mujoco.opt
    solution = solver.solve(
        mass,
        force,
        rows,
        state.qacc_warmstart,
        iterations=int(option.iterations),
        ls_iterations=int(option.ls_iterations),
        tolerance=float(option.tolerance),
    )
    return _Forward(data, mass, force, solution, touches, torque)


def _pushed(model: MujocoModel, data: Any, push: Float[Array, "3"]) -> Float[Array, " nv"]:
    """Returns what a push on the torso does to the degrees of freedom, N and N m."""
    arm = dynamics.point_offset(data, data.xipos[TORSO])
    wrench = jnp.concatenate([jnp.cross(arm, push), push])
    return dynamics.moves(model.mujoco, TORSO) * (data.cdof @ wrench)


def _rows(model: MujocoModel, data: Any, ground: Ground) -> tuple[Rows, tuple[Touches, ...]]:
    """Returns the constraints that MJX has found, then the ground's; and how that is touched."""
    pyramidal = int(model.mujoco.opt.cone) == _PYRAMIDAL
    parts, touched = [_found(model, data)], []
    for contacts in model.ground:
        touches = mujoco_ground.touch(contacts, model.mujoco, data, ground, model.planar)
        parts.append(contact_rows.rows(contacts, touches, model.mujoco, data, pyramidal=pyramidal))
        touched.append(touches)
    return solver.joined(parts), tuple(touched)


def _found(model: MujocoModel, data: Any) -> Rows:
    """Returns the constraints that MJX has found."""
    found = data._impl
    place = np.arange(found.efc_J.shape[0])
    equal = place < found.ne
    rubs = (place >= found.ne) & (place < found.ne + found.nf)
    most = found.efc_frictionloss
    cones: list[Cones] = []
    if int(model.mujoco.opt.cone) != _PYRAMIDAL:
        for dim in (3, 4, 6):
            here = np.flatnonzero(found.contact.dim == dim)
            if not here.size:
                continue
            friction = found.contact.friction[here, : dim - 1]
            regular = friction[:, :1] / np.sqrt(model.mujoco.opt.impratio)
            rows = found.contact.efc_address[here][:, None] + np.arange(dim)
            cones.append(Cones(rows, jnp.concatenate([regular, friction], axis=1)))
    turning = ties.turning(model, data)
    target = found.efc_aref
    if turning.size:
        target = target.at[: turning.size].add(-turning)
    return Rows(
        jacobian=found.efc_J,
        weight=found.efc_D,
        target=target,
        lowest=jnp.where(equal, -jnp.inf, jnp.where(rubs, -most, 0.0)),
        highest=jnp.where(rubs, most, jnp.inf),
        cones=tuple(cones),
    )


def _implicit(model: MujocoModel, now: _Forward, action: Action) -> Float[Array, "nv nv"] | None:
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
    data: Any,
    qpos: Float[Array, " nq"],
    qvel: Float[Array, " nv"],
    qacc: Float[Array, " nv"],
) -> tuple[Float[Array, " nq"], Float[Array, " nv"]]:
    """Returns positions and velocities after a step with these accelerations."""
    # With its damping off, MJX's integrator does nothing else, and it knows quaternions.
    flags = int(model.mujoco.opt.disableflags) | _NO_EULER_DAMPING
    ours = model.mjx.tree_replace({"opt.disableflags": flags})
    moved = mjx.euler(ours, data.replace(qpos=qpos, qvel=qvel, qacc=qacc))
    return moved.qpos, moved.qvel


def _runge_kutta(
    model: MujocoModel,
    state: MujocoState,
    forward: Callable[[MujocoState], _Forward],
    now: _Forward,
) -> tuple[Float[Array, " nq"], Float[Array, " nv"]]:
    """Returns positions and velocities after a step of the classical method of fourth order."""
    timestep = float(model.mujoco.opt.timestep)
    nothing = jnp.zeros_like(state.qvel)
    slope, qacc = state.qvel, now.solution.qacc
    total, gain = _SUM[0] * slope, _SUM[0] * qacc
    for share, weight in zip(_NEXT, _SUM[1:], strict=True):
        qpos, _ = _advance(model, now.data, state.qpos, share * slope, nothing)
        slope = state.qvel + timestep * share * qacc
        there = MujocoState(qpos, slope, qacc)
        qacc = forward(there).solution.qacc
        total, gain = total + weight * slope, gain + weight * qacc
    qpos, _ = _advance(model, now.data, state.qpos, total, nothing)
    return qpos, state.qvel + timestep * gain
