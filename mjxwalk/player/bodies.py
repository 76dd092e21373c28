"""What a body looks like and how its joints move it, as plain data for the page."""

from typing import Any

import msgspec
import numpy as np

from mjxwalk.envs import Anatomy, LeggedEnv
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import KINDS, ContactPoint, Side
from mjxwalk.envs.body_sides import body_sides
from mjxwalk.errors import RunError

Vector = tuple[float, ...]
SHAPES = {  # of a geom, by MuJoCo's number
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): "ellipsoid",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_MESH): "mesh",
}
FIRST_HIDDEN = 3  # group of geoms from which on MuJoCo's own viewer hides them


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
    """A point of a foot that touches the ground; `leg` is the place of the leg that it is of."""

    body: int
    leg: int
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
            f"a {type(env).__name__} has no anatomy to show; see how its runs went by `mjxwalk "
            "report RUN`, or derive an environment of your own from mjxwalk.envs.LeggedEnv"
        )
    model, anatomy = env.model.mujoco, env.anatomy
    sides = body_sides(model, anatomy)
    return Body(
        name=anatomy.name,
        links=tuple(_link(model, anatomy, body) for body in range(1, model.nbody)),
        parts=tuple(_part(model, geom, sides) for geom in _geoms(model)),
        points=tuple(_point(model, anatomy, point) for point in anatomy.points),
        sticks=tuple(_sticks(model, anatomy, sides)),
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
    """Returns the geoms that are shown: of a body, those of groups that MuJoCo shows, or all."""
    found: list[int] = []
    for body in range(1, model.nbody):
        first = int(model.body_geomadr[body])
        geoms = range(first, first + int(model.body_geomnum[body]))
        shown = [geom for geom in geoms if model.geom_group[geom] < FIRST_HIDDEN]
        found += shown or geoms
    return found


def _part(model: Any, geom: int, sides: tuple[Side, ...]) -> Part:
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
        side=sides[body],
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


def _point(model: Any, anatomy: Anatomy, point: ContactPoint) -> Point:
    body = int(model.body(point.body).id)
    pos = np.array(point.offset) + _apart(model, anatomy, body)
    place = anatomy.points.index(point)
    owners = [place in anatomy.points_of(leg) for leg in anatomy.legs]
    return Point(body=body - 1, leg=owners.index(True), side=point.side, pos=_rounded(pos))


def _apart(model: Any, anatomy: Anatomy, body: int) -> Any:
    """Returns how far to the side a foot is drawn.

    The legs of a body in the plane share it, and may be drawn side by side.
    """
    drawn = [model.geom_pos[geom][1] for geom in _geoms(model) if model.geom_bodyid[geom] == body]
    aside = float(drawn[0]) if drawn and anatomy.root.is_planar else 0.0
    return np.array([0.0, aside, 0.0])


def _sticks(model: Any, anatomy: Anatomy, sides: tuple[Side, ...]) -> list[Stick]:
    feet = {int(model.body(leg.foot).id): leg for leg in anatomy.legs}
    found: list[Stick] = []
    for body in range(1, model.nbody):
        if body in feet:
            heel, toe = anatomy.heel_and_toe(feet[body])
            places = (np.zeros(3), heel, toe, np.zeros(3))
            lines = [[_apart(model, anatomy, body) + place for place in places]]
        else:
            along = _along_geoms(model, body)
            # Of many a shape one line each would be a thicket.
            lines = along if len(along) == 1 else _to_children(model, body) or along
        found += [
            Stick(body=body - 1, side=sides[body], line=tuple(map(_rounded, line)))
            for line in lines
        ]
    return found


def _along_geoms(model: Any, body: int) -> list[Any]:
    """Returns a line along each capsule and box of a body."""
    found: list[Any] = []
    for geom in _geoms(model):
        shape, size = _shape(model, geom), model.geom_size[geom]
        if model.geom_bodyid[geom] != body or shape not in ("capsule", "box"):
            continue
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
        axis, half = (2, size[1]) if shape == "capsule" else (int(np.argmax(size)), max(size))
        along = half * turn.reshape(3, 3)[:, axis]
        found.append((model.geom_pos[geom] - along, model.geom_pos[geom] + along))
    return found


def _to_children(model: Any, body: int) -> list[Any]:
    """Returns a line from a body's origin to that of each body that it carries."""
    children = np.flatnonzero(model.body_parentid == body)
    return [(np.zeros(3), place) for place in model.body_pos[children] if place.any()]


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
