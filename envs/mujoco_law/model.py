"""The model that MuJoCo's contacts and constraints are computed with, of a body's file.

It is the file's own, but for what lets it be driven and told as every body here: a free root, or
slides and a hinge in the plane; hinges for ball joints; a motor for each driven joint.
"""

import copy
import functools
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from mjxwalk.envs._mujoco import compiled, mjx, mujoco
from mjxwalk.envs.derived import file_tree
from mjxwalk.envs.derived import motors as mjcf_motors
from mjxwalk.envs.derived.file_tree import FileTree
from mjxwalk.envs.derived.source import PLANE, Pose, geoms_of, joints_of
from mjxwalk.envs.mujoco_law import ground_geoms, layout, own_pairs, refusals
from mjxwalk.envs.mujoco_law.ground import GroundContacts
from mjxwalk.envs.mujoco_law.layout import Layout
from mjxwalk.envs.mujoco_law.own_pairs import OwnPairs
from mjxwalk.envs.mujoco_law.settings import MujocoContact

FLOOR = "floor of the trial"
FLOOD = 1000.0  # m; a floor so high touches every geom that it may touch
_INTEGRATORS = {
    "euler": mujoco.mjtIntegrator.mjINT_EULER,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "rk4": mujoco.mjtIntegrator.mjINT_RK4,
}
_CONES = {
    "pyramidal": mujoco.mjtCone.mjCONE_PYRAMIDAL,
    "elliptic": mujoco.mjtCone.mjCONE_ELLIPTIC,
}

_DEFAULTS = {  # what is added here and may have defaults
    "joint": "stiffness damping armature frictionloss limited range margin ref springref "
    "actfrclimited actfrcrange actgravcomp solref_limit solimp_limit solref_friction "
    "solimp_friction",
    "geom": "contype conaffinity condim priority friction solref solimp margin gap solmix",
    "actuator": "gear dyntype dynprm gaintype gainprm biastype biasprm ctrllimited ctrlrange "
    "forcelimited forcerange actlimited actrange damping armature",
}


class MujocoModel(NamedTuple):
    """A body under MuJoCo's contacts: constants only.

    Attributes:
      mujoco: the `mujoco.MjModel`, its floor level; its actuators are the motors, with gains that a
        step sets.
      mjx: the same model for MJX, which leaves out contacts with the floor, and all if there are
        `pairs`.
      data: the `mjx.Data` that every step starts from.
      layout: of its links.
      planar: whether the root moves in the plane.
      turn: from the axes of the file's root to those that are forward, left and up.
      feet: numbers of the bodies of each leg's foot, the one that tells where it is first; () where
        no legs are known.
      pairs: of geoms that may touch each other; () where they are left to MJX.
      ground: where geoms may touch the ground, by the dimension of contact.
      driven: degree of freedom of each motor.
      lowest: torque that each motor gives at least, N m.
      highest: torque that each motor gives at most, N m.
    """

    mujoco: Any
    mjx: Any
    data: Any
    layout: Layout
    planar: bool
    turn: Float[np.ndarray, "3 3"]
    feet: tuple[tuple[int, ...], ...]
    pairs: tuple[OwnPairs, ...]
    ground: tuple[GroundContacts, ...]
    driven: Any
    lowest: Float[np.ndarray, " motor"]
    highest: Float[np.ndarray, " motor"]


@functools.lru_cache(maxsize=16)
def of_text(text: str, law: MujocoContact, timestep: float) -> MujocoModel:
    """Returns the model of a body's MJCF.

    Raises:
      ValueError: the engines cannot move it, or MJX cannot compute its contacts or constraints.
    """
    spec, tree = spec_of(text, law, timestep), file_tree.of_text(text)
    motors = mjcf_motors.of_tree(tree)
    root = 3 if tree.planar else 6
    return made(
        spec,
        tree.source,
        planar=tree.planar,
        turn=tree.turn,
        feet=tuple(leg.foot for leg in tree.legs),
        driven=np.array([root + motor.joint for motor in motors]),
        lowest=np.array([motor.lowest for motor in motors], np.float32),
        highest=np.array([motor.highest for motor in motors], np.float32),
    )


def made(spec: Any, pose: Pose, **known: Any) -> MujocoModel:
    """Returns the model of a `mujoco.MjSpec` with a floor.

    Args:
      spec: of the body; its geoms are those of the file.
      pose: that trials start in, of the file.
      known: the other attributes.

    Raises:
      ValueError: MJX cannot compute its contacts or constraints.
    """
    model = compiled(spec)
    with jax.ensure_compile_time_eval():
        try:
            bare = _without_floor(spec, model)
            ours, data = mjx.put_model(bare), mjx.make_data(bare)
            pairs = own_pairs.find(bare, ours, data)
            if pairs:
                bare.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
                ours, data = mjx.put_model(bare), mjx.make_data(bare)
        except NotImplementedError as error:
            raise ValueError(
                f"contact law mujoco: MJX cannot compute it ({error}); use contact law points, or "
                "change the file"
            ) from None
    ground = tuple(_ground(pose, model))
    return MujocoModel(
        mujoco=model,
        mjx=ours,
        data=data,
        layout=layout.of_model(model),
        pairs=pairs,
        ground=ground,
        **known,
    )


def spec_of(text: str, law: MujocoContact, timestep: float) -> Any:
    """Returns the `mujoco.MjSpec` of a body's MJCF, with its floor and motors.

    Raises:
      ValueError: the engines cannot move it, or the law cannot do what the file says.
    """
    tree = file_tree.of_text(text)
    refusals.check(tree.source.model)
    spec = mujoco.MjSpec.from_string(text)
    set_options(spec, law, timestep)
    strip(spec)
    _forget_defaults(spec)
    _add_floor(spec, tree)
    _replace_joints(spec, tree)
    if not law.self_collision:
        leave_floor_alone_to_touch(spec)
    names = _names(spec, tree)
    for motor in mjcf_motors.of_tree(tree):
        limits = np.array([motor.lowest, motor.highest])
        limited = bool(np.isfinite(limits).all())
        spec.add_actuator(
            name=tree.joints[motor.joint].name,
            target=names[motor.joint],
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
            forcelimited=mujoco.mjtLimited(int(limited)),
            forcerange=limits if limited else np.zeros(2),
        )
    return spec


def set_options(spec: Any, law: MujocoContact, timestep: float) -> None:
    """Puts the law's settings into a `mujoco.MjSpec`."""
    option = spec.option
    option.timestep = timestep
    if law.iterations is not None:
        option.iterations = law.iterations
    if law.ls_iterations is not None:
        option.ls_iterations = law.ls_iterations
    if law.cone is not None:
        option.cone = _CONES[law.cone]
    if law.integrator is not None:
        option.integrator = _INTEGRATORS[law.integrator]
    elif int(option.integrator) == int(mujoco.mjtIntegrator.mjINT_IMPLICIT):
        # MJX has no derivatives of Coriolis forces, which alone set the two apart.
        option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON


def strip(spec: Any) -> None:
    """Takes out what does not move the body, and what the motors replace."""
    for kind in ("sensors", "keys", "actuators", "cameras", "lights"):
        for each in list(getattr(spec, kind)):
            spec.delete(each)


def _forget_defaults(spec: Any) -> None:
    """Makes what is added from here on as MuJoCo has it, whatever the file's `<default>` says."""
    usual = mujoco.MjSpec()
    for kind, names in _DEFAULTS.items():
        ours, blank = getattr(spec.default, kind), getattr(usual.default, kind)
        for name in names.split():
            value = getattr(blank, name)
            setattr(ours, name, value.copy() if isinstance(value, np.ndarray) else value)


def _add_floor(spec: Any, tree: FileTree) -> None:
    """Lays the file's floors level at height zero; adds one as MuJoCo has it if there is none."""
    for geom in list(spec.worldbody.geoms):
        if int(geom.type) == PLANE:
            geom.pos, geom.quat = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    if not floors(tree.source.model):
        spec.worldbody.add_geom(name=FLOOR, type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])


def floors(model: Any) -> list[int]:
    """Returns the numbers of the world's planes."""
    return [geom for geom in geoms_of(model, 0) if int(model.geom_type[geom]) == PLANE]


def _ground(pose: Pose, model: Any) -> list[GroundContacts]:
    """Returns where geoms may touch the ground, with what MuJoCo says of each with a floor."""
    flooded, planes = copy.deepcopy(model), floors(model)
    flooded.geom_pos[planes, 2], flooded.geom_sameframe[planes] = FLOOD, 0
    # The boxes by which MuJoCo passes over bodies of several geoms are those of the floor's place.
    flooded.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MIDPHASE)
    data = mujoco.MjData(flooded)
    mujoco.mj_fwdPosition(flooded, data)
    return ground_geoms.find(pose, model, data.contact, planes)


def _without_floor(spec: Any, model: Any) -> Any:
    """Returns the `mujoco.MjModel` in which nothing collides with a floor."""
    bare = spec.copy()
    for geom in list(bare.worldbody.geoms):
        if int(geom.type) == PLANE:
            geom.contype, geom.conaffinity = 0, 0
    planes = {str(model.geom(floor).name) for floor in floors(model)}
    for pair in list(bare.pairs):
        if planes & {pair.geomname1, pair.geomname2}:
            bare.delete(pair)
    return compiled(bare)


def leave_floor_alone_to_touch(spec: Any) -> None:
    """Lets geoms of the body collide with those of the world only."""
    bodies = [each for each in spec.bodies if each.name != "world"]
    for number, one in enumerate(bodies):
        for other in bodies[number + 1 :]:
            spec.add_exclude(bodyname1=one.name, bodyname2=other.name)
    for pair in list(spec.pairs):
        geoms = [spec.geom(name) for name in (pair.geomname1, pair.geomname2)]
        if all(geom.parent.name != "world" for geom in geoms):
            spec.delete(pair)


def _replace_joints(spec: Any, tree: FileTree) -> None:
    """Gives the root joints of its own kind and the others one hinge or slide a coordinate."""
    model = tree.source.model
    bodies = list(spec.bodies)  # in the model's order, the world first
    root = bodies[1]
    for joint in list(root.joints):
        spec.delete(joint)
    if tree.planar:
        root.pos, root.quat = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
        file_tree.add_root(root, planar=True)
    else:
        root.add_freejoint(name="root")
    for body in range(2, model.nbody):
        joints = list(bodies[body].joints)
        for joint, made in zip(joints_of(model, body), joints, strict=True):
            own = [each for each in tree.joints if each.joint == joint]
            if len(own) == 1:
                made.name = made.name or own[0].name
                continue
            if len(joints) > 1:
                raise ValueError(
                    f"body {bodies[body].name} has a ball joint beside others; give the ball "
                    "joint a body of its own"
                )
            spec.delete(made)
            for each in own:
                file_tree.add_joint(bodies[body], model, each)


def _names(spec: Any, tree: FileTree) -> list[str]:
    """Returns the name of each coordinate's joint below the root."""
    return [joint.name for body in list(spec.bodies)[2:] for joint in body.joints]
