"""What a body looks like and how its joints move it, as plain data for the page."""

from typing import Any, NamedTuple

import msgspec
import numpy as np

from mjxwalk.envs import Flame, Planar7, Reil, flame_body, planar7, reil_body
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.errors import RunError

Vector = tuple[float, ...]
SHAPES = {  # of a geom, by MuJoCo's number
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_MESH): "mesh",
}
MOVES = {  # of a joint
    int(mujoco.mjtJoint.mjJNT_SLIDE): "slide",
    int(mujoco.mjtJoint.mjJNT_HINGE): "hinge",
}


class Layout(NamedTuple):
    """Where a body's numbers lie.

    Attributes:
      coordinate: of the state's qpos, for each joint of the model.
      motors: which coordinates have one, in the order of an action.
      points: names of the sites that touch the ground, in the order of a state's contacts.
    """

    coordinate: tuple[int, ...]
    motors: tuple[int, ...]
    points: tuple[str, ...]


class Joint(msgspec.Struct, frozen=True, kw_only=True):
    """How a coordinate moves a body in its parent: along or about an axis."""

    move: str
    axis: Vector
    coordinate: int


class Link(msgspec.Struct, frozen=True, kw_only=True):
    """A body of the tree: its place in its parent, -1 the world, before its joints move it."""

    name: str
    parent: int
    pos: Vector
    quat: Vector
    joints: tuple[Joint, ...]


class Part(msgspec.Struct, frozen=True, kw_only=True):
    """A shape that a body carries; size, and w x y z of the turn, as in MuJoCo.

    Attributes:
      vertices: of a mesh, x, y and z in turn.
      faces: of a mesh, three vertices each.
    """

    body: int
    shape: str
    side: str
    size: Vector
    pos: Vector
    quat: Vector
    vertices: Vector = ()
    faces: tuple[int, ...] = ()


class Point(msgspec.Struct, frozen=True, kw_only=True):
    """A point of a foot that touches the ground."""

    body: int
    side: str
    pos: Vector


class Stick(msgspec.Struct, frozen=True, kw_only=True):
    """A line that stands for a part where walkers are drawn as stick figures, in its body."""

    body: int
    side: str
    line: tuple[Vector, ...]


class Angle(msgspec.Struct, frozen=True, kw_only=True):
    """A coordinate that is plotted.

    Attributes:
      name: of the joint, without its side.
      side: "left", "right", or "middle" of a joint that is no leg's.
      coordinate: of the state's qpos.
      motor: that drives it, None where nothing does.
    """

    name: str
    side: str
    coordinate: int
    motor: int | None


class Body(msgspec.Struct, frozen=True, kw_only=True):
    """All that the page has to know of a body."""

    name: str
    links: tuple[Link, ...]
    parts: tuple[Part, ...]
    points: tuple[Point, ...]
    sticks: tuple[Stick, ...]
    angles: tuple[Angle, ...]


def layout(env: Any) -> Layout:
    """Returns where the body's numbers lie.

    Raises:
      RunError: it is no body that can be shown.
    """
    if isinstance(env, Planar7):
        return Layout(
            tuple(range(9)), tuple(range(9))[planar7.ACTUATED], tuple(planar7.CONTACT_SITES)
        )
    if isinstance(env, Flame):
        return Layout(
            tuple(flame_body.COORDINATE.tolist()),
            tuple(flame_body.ACTUATED.tolist()),
            tuple(flame_body.CONTACT_SITES),
        )
    if isinstance(env, Reil):
        return Layout(
            tuple(range(reil_body.NUM_COORDINATES)),
            tuple(reil_body.HIPS.tolist()),
            reil_body.SPHERES,
        )
    raise RunError(f"a {type(env).__name__} cannot be shown; Planar7, Flame and Reil can")


def describe(env: Any) -> Body:
    """Returns the body of an environment.

    Raises:
      RunError: it is no body that can be shown.
    """
    where = layout(env)
    model = env.model.mujoco
    parts = tuple(_part(model, geom) for geom in _geoms(model))
    return Body(
        name=type(env).__name__,
        links=tuple(_link(model, where, body) for body in range(1, model.nbody)),
        parts=parts,
        points=tuple(_point(model, name) for name in where.points),
        sticks=tuple(_sticks(model, where)),
        angles=tuple(_angles(model, where)),
    )


def _link(model: Any, where: Layout, body: int) -> Link:
    first = int(model.body_jntadr[body])
    joints = range(first, first + int(model.body_jntnum[body]))
    return Link(
        name=str(model.body(body).name),
        parent=int(model.body_parentid[body]) - 1,
        pos=_rounded(model.body_pos[body]),
        quat=_rounded(model.body_quat[body]),
        joints=tuple(
            Joint(
                move=MOVES[int(model.jnt_type[joint])],
                axis=_rounded(model.jnt_axis[joint]),
                coordinate=where.coordinate[joint],
            )
            for joint in joints
        ),
    )


def _geoms(model: Any) -> list[int]:
    return [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] > 0]


def _part(model: Any, geom: int) -> Part:
    body, shape = int(model.geom_bodyid[geom]), SHAPES[int(model.geom_type[geom])]
    vertices, faces = (), ()
    if shape == "mesh":
        mesh = model.mesh(int(model.geom_dataid[geom]))
        first, num = int(mesh.vertadr[0]), int(mesh.vertnum[0])
        vertices = _rounded(model.mesh_vert[first : first + num].ravel())
        first, num = int(mesh.faceadr[0]), int(mesh.facenum[0])
        faces = tuple(model.mesh_face[first : first + num].ravel().tolist())
    return Part(
        body=body - 1,
        shape=shape,
        side=_side(model.body(body).name),
        size=_rounded(model.geom_size[geom]),
        pos=_rounded(model.geom_pos[geom]),
        quat=_rounded(model.geom_quat[geom]),
        vertices=vertices,
        faces=faces,
    )


def _point(model: Any, name: str) -> Point:
    site = model.site(name).id
    body = int(model.site_bodyid[site])
    pos = model.site_pos[site] + _apart(model, body)
    return Point(body=body - 1, side=_side(name), pos=_rounded(pos))


def _apart(model: Any, body: int) -> Any:
    """Returns how far to the side a foot is drawn.

    The planar body's legs share a plane, and are drawn side by side.
    """
    drawn = [model.geom_pos[geom][1] for geom in _geoms(model) if model.geom_bodyid[geom] == body]
    return np.array([0.0, float(drawn[0]) if drawn else 0.0, 0.0])


def _sticks(model: Any, where: Layout) -> list[Stick]:
    feet = {int(model.site_bodyid[model.site(name).id]) for name in where.points}
    found: list[Stick] = []
    for geom in _geoms(model):
        body, shape = int(model.geom_bodyid[geom]), SHAPES[int(model.geom_type[geom])]
        half = float(max(model.geom_size[geom])) if shape == "box" else model.geom_size[geom][1]
        if body in feet or shape in ("sphere", "mesh"):
            continue
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
        along = half * turn.reshape(3, 3)[:, 2]
        ends = (model.geom_pos[geom] - along, model.geom_pos[geom] + along)
        found.append(_stick(model, body, ends))
    for body in sorted(feet):
        ends = [
            model.site_pos[site] + _apart(model, body)
            for site in (model.site(name).id for name in where.points)
            if model.site_bodyid[site] == body
        ]
        ankle = _apart(model, body)
        middle = np.mean([end[0] for end in ends])
        heel, toe = (
            np.mean([end for end in ends if (end[0] > middle) == front], axis=0)
            for front in (False, True)
        )
        found.append(_stick(model, body, (ankle, heel, toe, ankle)))
    return found


def _stick(model: Any, body: int, line: Any) -> Stick:
    return Stick(
        body=body - 1,
        side=_side(model.body(body).name),
        line=tuple(_rounded(point) for point in line),
    )


def _angles(model: Any, where: Layout) -> list[Angle]:
    found: dict[int, Angle] = {}
    for joint, coordinate in enumerate(where.coordinate):
        name = str(model.joint(joint).name)
        if name.startswith("root_") or coordinate in found:
            continue
        side = _side(name) if where.coordinate.count(coordinate) == 1 else "middle"
        motor = where.motors.index(coordinate) if coordinate in where.motors else None
        plain = name.removesuffix("_left").removesuffix("_right").replace("_", " ")
        found[coordinate] = Angle(name=plain, side=side, coordinate=coordinate, motor=motor)
    return list(found.values())


def _side(name: str) -> str:
    ending = name.rpartition("_")[2]
    return ending if ending in ("left", "right") else "middle"


def _rounded(values: Any) -> Vector:
    return tuple(round(float(value), 6) + 0.0 for value in values)
