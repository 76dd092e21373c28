"""The tree that the engines move, of any file's body: hinges and slides below a root with axes.

The root of a file may be free, or move by slides and hinges, and stand anywhere, turned anyhow.
Here it has slides along the world's axes, and hinges for yaw, pitch and roll, or x, z and pitch in
the plane, and walks along x. A ball joint becomes three hinges. All else is as MuJoCo compiled it.
"""

import functools
import itertools
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.envs import dynamics, floating, frames
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import HINGE, SLIDE, Side, side_of
from mjxwalk.envs.derived import legs as mjcf_legs
from mjxwalk.envs.derived import points as mjcf_points
from mjxwalk.envs.derived import roots
from mjxwalk.envs.derived import source as mjcf_source
from mjxwalk.envs.derived.source import BALL, Pose, joints_of

SLIDES = (("root_x", (1, 0, 0)), ("root_y", (0, 1, 0)), ("root_z", (0, 0, 1)))
TURNS = (("root_yaw", (0, 0, 1)), ("root_pitch", (0, 1, 0)), ("root_roll", (1, 0, 0)))
PLANAR = ("root_x", "root_z", "root_pitch")
# The rotations that put axes on axes.
SQUARE = [
    turn
    for order in itertools.permutations(np.eye(3))
    for signs in itertools.product((1.0, -1.0), repeat=3)
    if np.linalg.det(turn := np.array(order) * np.array(signs)[:, None]) > 0.5
]


class FileJoint(NamedTuple):
    """A coordinate below the root.

    Attributes:
      name: of it.
      joint: number of the file's joint.
      axis: of that joint in its body.
      start: its value in the pose that trials start in, rad or m.
    """

    name: str
    joint: int
    axis: Float[np.ndarray, "3"]
    start: float


class FileTree(NamedTuple):
    """A file's body as the engines move it.

    Attributes:
      source: the file's own model in its start pose.
      spec: `mujoco.MjSpec` with a joint for each of the root's coordinates; not to be changed.
      hinged: the `dynamics.Model` with a joint for each of the root's coordinates.
      floating: the same with a free root; None in the plane.
      planar: whether it moves in the plane.
      body_names: of each body of the file, marked with its side where a leg's name does not say it.
      joints: the coordinates below the root.
      legs: of the body.
      points: of each leg.
      turn: from the root's axes in the file to those here: forward, left and up.
      attitude: yaw, pitch and roll of the root in the start pose, or the pitch alone, rad.
    """

    source: Pose
    spec: Any
    hinged: dynamics.Model
    floating: dynamics.Model | None
    planar: bool
    body_names: tuple[str, ...]
    joints: tuple[FileJoint, ...]
    legs: tuple[mjcf_legs.FileLeg, ...]
    points: tuple[tuple[mjcf_points.Point, ...], ...]
    turn: Float[np.ndarray, "3 3"]
    attitude: tuple[float, ...]


@functools.cache
def of_text(text: str) -> FileTree:
    """Returns the tree of a body's MJCF.

    Raises:
      ValueError: the engines cannot move it, or it has no two legs.
    """
    pose = mjcf_source.start(text)
    model = pose.model
    roots.check(model)
    planar = roots.is_planar(model)
    legs = mjcf_legs.find(pose)
    height = float(pose.data.xpos[1][2]) - min(
        point[2] for geom in range(model.ngeom) for point in mjcf_points.of_geom(pose, geom)
    )
    points = [
        tuple(
            mjcf_points.of_foot(pose, list(leg.foot), planar=planar, reach=mjcf_legs.LOW * height)
        )
        for leg in legs
    ]
    turn, attitude = _turned(pose, legs, planar)
    names = _body_names(model, legs)
    joints = _joints(pose, legs)
    spec = _spec(pose, planar, turn, names, joints, points)
    hinged = dynamics.compile_model(spec.copy())
    free = None if planar else dynamics.compile_model(floating.freed(spec.copy(), names[1]))
    return FileTree(
        pose, spec, hinged, free, planar, names, joints, tuple(legs), tuple(points), turn, attitude
    )


def friction(text: str) -> float:
    """Returns the least friction coefficient of the feet."""
    tree = of_text(text)
    model = tree.source.model
    return min(mjcf_points.friction_of(model, list(leg.foot)) for leg in tree.legs)


def _turned(
    pose: Pose, legs: list[mjcf_legs.FileLeg], planar: bool
) -> tuple[Float[np.ndarray, "3 3"], tuple[float, ...]]:
    """Returns what turns the root's axes forward, left and up, and its attitude at the start."""
    attitude = pose.data.xmat[1].reshape(3, 3)
    if planar:
        if not np.allclose(attitude[1], [0.0, 1.0, 0.0], atol=1e-6):
            raise ValueError(f"body {pose.model.body(1).name} is turned out of the plane")
        return np.eye(3), (float(np.arctan2(attitude[0, 2], attitude[0, 0])),)
    ahead = _ahead(pose, legs)
    upright = ahead @ attitude
    square = max(SQUARE, key=lambda turn: float(np.trace(turn.T @ upright)))
    rest = upright @ square.T
    yaw, roll = np.arctan2(rest[1, 0], rest[0, 0]), np.arctan2(rest[2, 1], rest[2, 2])
    return square, (float(yaw), float(-np.arcsin(np.clip(rest[2, 0], -1, 1))), float(roll))


def _ahead(pose: Pose, legs: list[mjcf_legs.FileLeg]) -> Float[np.ndarray, "3 3"]:
    """Returns the quarter turn about the vertical after which left legs are left of right ones."""

    def middle(side: Side) -> Any:
        places = [pose.data.xpos[leg.top] for leg in legs if leg.side == side]
        places += [pose.data.xpos[leg.foot[0]] for leg in legs if leg.side == side]
        return np.mean(places, axis=0) if places else None

    left, right = middle("left"), middle("right")
    if left is None or right is None or np.linalg.norm((left - right)[:2]) < mjcf_legs.CLOSE:
        return np.eye(3)
    x, y, _ = left - right
    quarters = round(np.arctan2(-x, y) / (np.pi / 2))  # how far left is turned from the y axis
    cosine, sine = np.cos(quarters * np.pi / 2), np.sin(quarters * np.pi / 2)
    return np.round(np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]]))


def _body_names(model: Any, legs: list[mjcf_legs.FileLeg]) -> tuple[str, ...]:
    names = [str(model.body(body).name) or f"body_{body}" for body in range(model.nbody)]
    for body in range(1, model.nbody):
        for leg in legs:
            if leg.top in mjcf_source.parents(model, body):
                names[body] = _marked(names[body], leg.side)
    return tuple(names)


def _marked(name: str, side: Side) -> str:
    return name if side == "middle" or side_of(name) == side else f"{name}_{side}"


def _joints(pose: Pose, legs: list[mjcf_legs.FileLeg]) -> tuple[FileJoint, ...]:
    model, data = pose
    found: list[FileJoint] = []
    for body in range(2, model.nbody):
        for joint in joints_of(model, body):
            name = str(model.joint(joint).name) or f"joint_{joint}"
            for leg in legs:
                if joint in leg.joints:
                    name = _marked(name, leg.side)
            place = int(model.jnt_qposadr[joint])
            if int(model.jnt_type[joint]) != BALL:
                axis = np.array(model.jnt_axis[joint])
                found.append(FileJoint(name, joint, axis, float(data.qpos[place])))
                continue
            turn = frames.matrix(data.qpos[place : place + 4])
            angles = (
                np.arctan2(turn[1, 0], turn[0, 0]),
                -np.arcsin(np.clip(turn[2, 0], -1.0, 1.0)),
                np.arctan2(turn[2, 1], turn[2, 2]),
            )
            found += [
                FileJoint(f"{word}_{name}", joint, axis, float(angle))
                for word, axis, angle in zip("zyx", np.eye(3)[::-1], angles, strict=True)
            ]
    return tuple(found)


def _spec(
    pose: Pose,
    planar: bool,
    turn: Float[np.ndarray, "3 3"],
    names: tuple[str, ...],
    joints: tuple[FileJoint, ...],
    points: list[tuple[mjcf_points.Point, ...]],
) -> Any:
    """Returns the `mujoco.MjSpec` of the tree, with a site for each contact point."""
    model = pose.model
    spec = mujoco.MjSpec()
    spec.modelname = str(model.names[: model.names.index(b"\0")].decode()) or "body"
    spec.compiler.degree = False
    spec.option.timestep = model.opt.timestep
    made = {0: spec.worldbody}
    for body in range(1, model.nbody):
        parent = int(model.body_parentid[body])
        front = turn if body == 1 else np.eye(3)  # of what the root itself holds
        lift = turn if parent == 1 else np.eye(3)  # of where its children are
        made[body] = made[parent].add_body(
            name=names[body],
            pos=np.zeros(3) if body == 1 else lift @ model.body_pos[body],
            quat=[1, 0, 0, 0] if body == 1 else _after(lift, model.body_quat[body]),
            mass=model.body_mass[body],
            ipos=front @ model.body_ipos[body],
            iquat=_after(front, model.body_iquat[body]),
            inertia=model.body_inertia[body],
            explicitinertial=True,
        )
        if body == 1:
            add_root(made[1], planar)
        for each in joints:
            if int(model.jnt_bodyid[each.joint]) == body:
                add_joint(made[body], model, each)
        for geom in mjcf_source.geoms_of(model, body):
            _add_geom(spec, made[body], model, geom, front)
    for foot in points:
        for point in foot:
            front = turn if point.body == 1 else np.eye(3)
            made[point.body].add_site(name=point.name, pos=front @ point.offset)
    return spec


def _after(turn: Float[np.ndarray, "3 3"], quat: Float[np.ndarray, "4"]) -> Any:
    """Returns a quaternion turned further; the same one where nothing turns it."""
    if np.array_equal(turn, np.eye(3)):
        return np.array(quat)
    return mjcf_source.quaternion(turn @ frames.matrix(quat))


def add_root(body: Any, planar: bool) -> None:
    """Adds a joint for each of the root's coordinates to a body of a `mujoco.MjSpec`."""
    for kind, axes in ((SLIDE, SLIDES), (HINGE, TURNS)):
        for name, axis in axes:
            if not planar or name in PLANAR:
                body.add_joint(name=name, type=mujoco.mjtJoint(kind), axis=axis)


def add_joint(body: Any, model: Any, each: FileJoint) -> None:
    """Adds the joint of a coordinate to a body of a `mujoco.MjSpec`."""
    joint = each.joint
    slide, ball = (int(model.jnt_type[joint]) == kind for kind in (SLIDE, BALL))
    place, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    limited = bool(model.jnt_limited[joint])
    lower, upper = model.jnt_range[joint]
    body.add_joint(
        name=each.name,
        type=mujoco.mjtJoint(SLIDE if slide else HINGE),
        pos=model.jnt_pos[joint],
        axis=each.axis,
        range=(-upper, upper) if ball else (lower, upper),
        limited=mujoco.mjtLimited.mjLIMITED_TRUE if limited else mujoco.mjtLimited.mjLIMITED_FALSE,
        ref=0.0 if ball else model.qpos0[place],
        armature=model.dof_armature[dof],
        damping=model.dof_damping[dof],
        frictionloss=model.dof_frictionloss[dof],
        stiffness=model.jnt_stiffness[joint],
        springref=0.0 if ball else model.qpos_spring[place],
    )


def _add_geom(spec: Any, body: Any, model: Any, geom: int, turn: Float[np.ndarray, "3 3"]) -> None:
    """Adds a geom that is drawn and collides with nothing."""
    kind, drawn = mujoco.mjtGeom(int(model.geom_type[geom])), {}
    if int(model.geom_type[geom]) == mjcf_source.MESH:
        mesh = int(model.geom_dataid[geom])
        first, num = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        name = f"mesh_{geom}"
        added = spec.add_mesh(name=name)
        added.uservert = np.array(model.mesh_vert[first : first + num], np.float32).reshape(-1)
        drawn = {"meshname": name}
    material = int(model.geom_matid[geom])
    colour = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    body.add_geom(
        type=kind,
        size=model.geom_size[geom],
        pos=turn @ model.geom_pos[geom],
        quat=_after(turn, model.geom_quat[geom]),
        rgba=colour,
        group=int(model.geom_group[geom]),
        contype=0,
        conaffinity=0,
        mass=0.0,
        **drawn,
    )
