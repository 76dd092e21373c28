"""What a body looks like and how its joints move it, as plain data for the page."""

from typing import Any

import msgspec
import numpy as np

from mjxwalk.envs import Anatomy, LeggedEnv
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import KINDS, ContactPoint, side_of
from mjxwalk.errors import RunError

Vector = tuple[float, ...]
SHAPES = {  # of a geom, by MuJoCo's number
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_MESH): "mesh",
}


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


def describe(env: Any) -> Body:
    """Returns the body of an environment.

    Raises:
      RunError: it has no anatomy, or a shape that pages cannot show.
    """
    if not isinstance(env, LeggedEnv):
        raise RunError(
            f"a {type(env).__name__} has no anatomy to show; derive it from mjxwalk.envs.LeggedEnv"
        )
    model, anatomy = env.model.mujoco, env.anatomy
    parts = tuple(_part(model, geom) for geom in _geoms(model))
    return Body(
        name=anatomy.name,
        links=tuple(_link(model, anatomy, body) for body in range(1, model.nbody)),
        parts=parts,
        points=tuple(_point(model, point) for point in anatomy.points),
        sticks=tuple(_sticks(model, anatomy)),
        angles=tuple(_angles(anatomy)),
    )


def _link(model: Any, anatomy: Anatomy, body: int) -> Link:
    first = int(model.body_jntadr[body])
    joints = range(first, first + int(model.body_jntnum[body]))
    return Link(
        name=str(model.body(body).name),
        parent=int(model.body_parentid[body]) - 1,
        pos=_rounded(model.body_pos[body]),
        quat=_rounded(model.body_quat[body]),
        joints=tuple(
            Joint(
                move=KINDS[int(model.jnt_type[joint])],
                axis=_rounded(model.jnt_axis[joint]),
                coordinate=anatomy.joint_coordinate[joint],
            )
            for joint in joints
        ),
    )


def _geoms(model: Any) -> list[int]:
    return [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] > 0]


def _part(model: Any, geom: int) -> Part:
    body, shape = int(model.geom_bodyid[geom]), _shape(model, geom)
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
        side=side_of(str(model.body(body).name)),
        size=_rounded(model.geom_size[geom]),
        pos=_rounded(model.geom_pos[geom]),
        quat=_rounded(model.geom_quat[geom]),
        vertices=vertices,
        faces=faces,
    )


def _shape(model: Any, geom: int) -> str:
    kind = int(model.geom_type[geom])
    if kind not in SHAPES:
        name = mujoco.mjtGeom(kind).name.removeprefix("mjGEOM_").lower()
        raise RunError(
            f"the body has a geom of type {name}, which pages cannot show; draw it with "
            f"{', '.join(SHAPES.values())}"
        )
    return SHAPES[kind]


def _point(model: Any, point: ContactPoint) -> Point:
    body = int(model.body(point.body).id)
    pos = np.array(point.offset) + _apart(model, body)
    return Point(body=body - 1, side=point.side, pos=_rounded(pos))


def _apart(model: Any, body: int) -> Any:
    """Returns how far to the side a foot is drawn.

    The planar body's legs share a plane, and are drawn side by side.
    """
    drawn = [model.geom_pos[geom][1] for geom in _geoms(model) if model.geom_bodyid[geom] == body]
    return np.array([0.0, float(drawn[0]) if drawn else 0.0, 0.0])


def _sticks(model: Any, anatomy: Anatomy) -> list[Stick]:
    feet = {int(model.body(leg.foot).id): leg for leg in anatomy.legs}
    found: list[Stick] = []
    for geom in _geoms(model):
        body, shape = int(model.geom_bodyid[geom]), _shape(model, geom)
        half = float(max(model.geom_size[geom])) if shape == "box" else model.geom_size[geom][1]
        if body in feet or shape in ("sphere", "mesh"):
            continue
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
        along = half * turn.reshape(3, 3)[:, 2]
        ends = (model.geom_pos[geom] - along, model.geom_pos[geom] + along)
        found.append(_stick(model, body, ends))
    for body in sorted(feet):
        heel, toe = anatomy.heel_and_toe(feet[body])
        line = [_apart(model, body) + place for place in (np.zeros(3), heel, toe, np.zeros(3))]
        found.append(_stick(model, body, line))
    return found


def _stick(model: Any, body: int, line: Any) -> Stick:
    return Stick(
        body=body - 1,
        side=side_of(str(model.body(body).name)),
        line=tuple(_rounded(point) for point in line),
    )


def _angles(anatomy: Anatomy) -> list[Angle]:
    driven = anatomy.driven.tolist()
    return [
        Angle(
            name=each.words,
            side=each.side,
            coordinate=place,
            motor=driven.index(place) if place in driven else None,
        )
        for place, each in enumerate(anatomy.coordinates)
        if place >= anatomy.root.num
    ]


def _rounded(values: Any) -> Vector:
    return tuple(round(float(value), 6) + 0.0 for value in values)
