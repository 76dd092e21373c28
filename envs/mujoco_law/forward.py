"""Accelerations of a state with MuJoCo's own contacts and constraints, and what they come of."""

import functools
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import dynamics, motor
from mjxwalk.envs._mujoco import mjx, mujoco
from mjxwalk.envs.motor import Action, Limits
from mjxwalk.envs.mujoco_law import constraints, own_pairs, smooth, solver, ties, tree_data
from mjxwalk.envs.mujoco_law import ground as mujoco_ground
from mjxwalk.envs.mujoco_law import rows as contact_rows
from mjxwalk.envs.mujoco_law import softness as softnesses
from mjxwalk.envs.mujoco_law import tree as mujoco_tree
from mjxwalk.envs.mujoco_law.constraints import Cones, Part, Rows
from mjxwalk.envs.mujoco_law.ground import Ground, GroundContacts, Touches, level
from mjxwalk.envs.mujoco_law.model import MujocoModel
from mjxwalk.envs.mujoco_law.own_pairs import OwnPairs, Slots
from mjxwalk.envs.mujoco_law.smooth import Masses
from mjxwalk.envs.mujoco_law.solver import Solution
from mjxwalk.envs.mujoco_law.tree import Tree

_PYRAMIDAL = int(mujoco.mjtCone.mjCONE_PYRAMIDAL)
_NO_GRAVITY = int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
TORSO = 1  # number of the body that carries the others


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


class Forward(NamedTuple):
    """Accelerations of a state, and all that they came of.

    Attributes:
      tree: where it is, and what a free root's turning counts about in all that follows.
      data: the `mjx.Data` with places and velocities.
      mass: matrix of the degrees of freedom, kg or kg m^2.
      force: on them without constraints, N or N m.
      solution: of the constraints; those of own pairs come before those of the ground, the last.
      own: pairs of the body's own geoms that touch, as `MujocoModel.pairs` has them.
      touches: how the ground is touched, as `MujocoModel.ground` has it.
      torque: of each motor, N m.
    """

    tree: Tree
    data: Any
    mass: Float[Array, "nv nv"]
    force: Float[Array, " nv"]
    solution: Solution
    own: tuple[tuple[OwnPairs, Slots, Touches], ...]
    touches: tuple[Touches, ...]
    torque: Float[Array, " motor"]


def compute(
    model: MujocoModel,
    state: MujocoState,
    action: Action,
    ground: Ground = level,
    burden: Burden = NOTHING,
) -> Forward:
    """Returns accelerations, and all that they came of."""
    tree = mujoco_tree.of_positions(model.layout, state.qpos)
    rates = mujoco_tree.about_world(tree, state.qvel)
    data = mjx.collision(model.mjx, tree_data.of_tree(model, tree, state.qpos, rates))
    masses = smooth.masses(tree)
    if burden.load is not None:
        masses = smooth.with_mass(tree, masses, burden.load)
    limits = Limits(model.lowest, model.highest)
    joints = model.driven + (state.qpos.shape[0] - state.qvel.shape[0])
    torque = motor.driven(
        action, state.qpos[joints], state.qvel[model.driven], limits, ahead=0.0
    ).torque
    force = data.qfrc_passive - _bias(model, tree, masses, data)
    force = force.at[model.driven].add(torque)
    if burden.push is not None:
        force += _pushed(model, data, burden.push)
    mass = _mass(model, tree, masses, data)
    parts, touched = _parts(model, data, ground)
    option = model.mujoco.opt
    solution = solver.solve(
        mass,
        force,
        parts,
        mujoco_tree.about_world(tree, state.qacc_warmstart),
        iterations=int(option.iterations),
        ls_iterations=int(option.ls_iterations),
        tolerance=float(option.tolerance),
    )
    return Forward(tree, data, mass, force, solution, touched.own, touched.ground, torque)


def _bias(model: MujocoModel, tree: Tree, masses: Masses, data: Any) -> Float[Array, " nv"]:
    """Returns the force that keeps all rates as they are, N and N m."""
    found = model.mujoco
    weightless = int(found.opt.disableflags) & _NO_GRAVITY
    gravity = np.zeros(3) if weightless else np.array(found.opt.gravity)
    still = jnp.zeros_like(data.qvel)
    force = smooth.force_of_motion(tree, masses, data.qvel, still, gravity)
    if found.ntendon and found.tendon_armature.any():
        force = mjx.tendon_bias(model.mjx, data.replace(qfrc_bias=force)).qfrc_bias
    return force


def _mass(model: MujocoModel, tree: Tree, masses: Masses, data: Any) -> Float[Array, "nv nv"]:
    """Returns the mass matrix with armatures of joints and tendons."""
    found = model.mujoco
    matrix = smooth.mass_matrix(tree, masses)
    matrix += jnp.diag(jnp.asarray(found.dof_armature, matrix.dtype))
    if found.ntendon and found.tendon_armature.any():
        along = data._impl.ten_J
        matrix += along.T @ (model.mjx.tendon_armature[:, None] * along)
    return matrix


def _pushed(model: MujocoModel, data: Any, push: Float[Array, "3"]) -> Float[Array, " nv"]:
    """Returns what a push on the torso does to the degrees of freedom, N and N m."""
    arm = dynamics.point_offset(data, data.xipos[TORSO])
    wrench = jnp.concatenate([jnp.cross(arm, push), push])
    return dynamics.moves(model.mujoco, TORSO) * (data.cdof @ wrench)


class _Touched(NamedTuple):
    """Contacts of a state, as `Forward` has them."""

    own: tuple[tuple[OwnPairs, Slots, Touches], ...]
    ground: tuple[Touches, ...]


def _parts(model: MujocoModel, data: Any, ground: Ground) -> tuple[list[Part], _Touched]:
    """Returns constraints as MJX finds them, those of own pairs, the ground's; and contacts."""
    pyramidal = int(model.mujoco.opt.cone) == _PYRAMIDAL
    rows = _found(model, mjx.make_constraint(model.mjx, data))
    parts = [Part(lambda: rows)]
    own: list[tuple[OwnPairs, Slots, Touches]] = []
    for pairs in model.pairs:
        for slots in own_pairs.touching(pairs, data):

            def of_slots(pairs: OwnPairs = pairs, slots: Slots = slots) -> Rows:
                touches = own_pairs.touches(pairs, slots, data)
                softness = softnesses.of_numbers(pairs.softness, slots.pair)
                return contact_rows.rows(softness, touches, model.mujoco, data, pyramidal=pyramidal)

            part = Part(of_slots, jnp.any(slots.filled))
            has_cones = pairs.softness.dim > 1 and not pyramidal
            remakes = has_cones or own_pairs.is_rare(slots)
            parts.append(part if remakes else constraints.kept(part))
            own.append((pairs, slots, own_pairs.touches(pairs, slots, data)))
    touched: list[Touches] = []
    for contacts in model.ground:

        def touch(contacts: GroundContacts = contacts) -> Touches:
            return mujoco_ground.touch(contacts, model.mujoco, data, ground, model.planar)

        def of_ground(contacts: GroundContacts = contacts, touch: Any = touch) -> Rows:
            softness = mujoco_ground.softness_of(contacts, model.mujoco)
            return contact_rows.rows(softness, touch(), model.mujoco, data, pyramidal=pyramidal)

        touched.append(touch())
        if contacts.is_rare:
            parts.append(Part(of_ground, jnp.any(touched[-1].touching)))
        else:
            parts.append(Part(functools.cache(of_ground)))
    return parts, _Touched(tuple(own), tuple(touched))


def _found(model: MujocoModel, data: Any) -> Rows:
    """Returns the constraints that MJX finds."""
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
