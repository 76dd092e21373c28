"""The ground under MuJoCo's contacts: where geoms touch it, for any heights that a trial brings.

MuJoCo knows planes and height fields; a height field of a trial's own would cost each contact a
search among its triangles. Here the ground is, under each point that may touch it, the plane that
lies there. On level ground these are the contacts that C MuJoCo has of a plane with spheres,
capsules, boxes, cylinders and ellipsoids.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mujoco_law import softness
from mjxwalk.envs.mujoco_law.softness import Softness

_GEOM = mujoco.mjtGeom
SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = (
    int(each)
    for each in (
        _GEOM.mjGEOM_SPHERE,
        _GEOM.mjGEOM_CAPSULE,
        _GEOM.mjGEOM_ELLIPSOID,
        _GEOM.mjGEOM_CYLINDER,
        _GEOM.mjGEOM_BOX,
        _GEOM.mjGEOM_MESH,
    )
)
# One corner of each of a box's diagonals; of a corner and its opposite, the lower one touches.
_CORNERS = np.array([[1, 1, 1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]], np.float32)
_SMALL = 1e-12  # lengths that point nowhere


class Under(NamedTuple):
    """The ground at a place.

    Attributes:
      height: m.
      gradient: m upwards for each m along x; None where the ground counts as level, whatever
        heights are near.
      stiffness: factor of what pushes a foot out of the ground; None for 1.
      friction: factor of the coefficient; None for 1.
    """

    height: Float[Array, ""]
    gradient: Float[Array, ""] | None = None
    stiffness: Float[Array, ""] | None = None
    friction: Float[Array, ""] | None = None


# From x and y (None in the plane), m, to what is there.
Ground = Callable[[Float[Array, ""], Float[Array, ""] | None], Under]


def level(x: Float[Array, ""], y: Float[Array, ""] | None) -> Under:
    """Returns level ground at height zero."""
    del x, y
    return Under(jnp.zeros(()))


class GroundContacts(NamedTuple):
    """Points of geoms that may touch the ground, all of one dimension: constants only.

    Attributes:
      dim: 1 without friction; 3 with friction along the ground; 4 and 6 also against turning.
      shapes: kind of geom, and the geoms of this kind.
      corners: of each mesh, the points that may touch, in the geom's axes, m.
      geom: number of the geom of each point.
      body: number of its body.
      margin: distance below which a point touches, m.
      friction: coefficients along two axes, of turning, and of rolling about two axes.
      solref: MuJoCo's stiffness and damping.
      solreffriction: the same of friction; zeros for that of the normal.
      solimp: MuJoCo's impedance.
      is_rare: whether they are of geoms that are far above the ground as trials start.
    """

    dim: int
    shapes: tuple[tuple[int, tuple[int, ...]], ...]
    corners: tuple[Float[np.ndarray, "corner 3"], ...]
    geom: Int[np.ndarray, " point"]
    body: Int[np.ndarray, " point"]
    margin: Float[np.ndarray, " point"]
    friction: Float[np.ndarray, "point 5"]
    solref: Float[np.ndarray, "point 2"]
    solreffriction: Float[np.ndarray, "point 2"]
    solimp: Float[np.ndarray, "point 5"]
    is_rare: bool


class Touches(NamedTuple):
    """How points are to the ground in one state.

    Attributes:
      distance: from the ground, m; negative within.
      place: halfway between a point and the ground, world axes, m.
      frame: rows are the ground's normal and two axes along it.
      touching: whether they are within their margin.
      under: the ground there.
    """

    distance: Float[Array, " point"]
    place: Float[Array, "point 3"]
    frame: Float[Array, "point 3 3"]
    touching: Bool[Array, " point"]
    under: Under


def softness_of(contacts: GroundContacts, model: Any) -> Softness:
    """Returns how contacts yield."""
    return softness.of_contacts(
        model,
        contacts.dim,
        np.stack([np.zeros_like(contacts.body), contacts.body], axis=1),
        contacts.margin,
        contacts.friction,
        contacts.solref,
        contacts.solreffriction,
        contacts.solimp,
    )


def touch(contacts: GroundContacts, model: Any, data: Any, ground: Ground, planar: bool) -> Touches:
    """Returns how the points are to the ground.

    Args:
      contacts: of one dimension.
      model: the `mujoco.MjModel`.
      data: the `mjx.Data` with the places of geoms.
      ground: that is walked on.
      planar: whether the body moves in the plane.
    """
    centre, radius, along = _points(contacts, model, data)

    def one(point: Array, radius: Array, along: Array, margin: Array) -> Touches:
        under = ground(point[0], None if planar else point[1])
        zero = jnp.zeros_like(point[2])
        if under.gradient is None:
            normal = jnp.stack([zero, zero, zero + 1.0])
        else:
            upward = jax.lax.rsqrt(1.0 + under.gradient**2)
            normal = jnp.stack([-under.gradient * upward, zero, upward])
        distance = (point[2] - under.height) * normal[2] - radius
        place = point - normal * (radius + 0.5 * distance)
        first = along - normal * (normal @ along)
        first = first * jax.lax.rsqrt(jnp.maximum(first @ first, _SMALL))
        frame = jnp.stack([normal, first, jnp.cross(normal, first)])
        return Touches(distance, place, frame, distance < margin, under)

    return jax.vmap(one)(centre, radius, along, jnp.asarray(contacts.margin, centre.dtype))


def _points(
    contacts: GroundContacts, model: Any, data: Any
) -> tuple[Float[Array, "point 3"], Float[Array, " point"], Float[Array, "point 3"]]:
    """Returns centres of spheres that touch, m; their radii, m; and friction's first axis."""
    parts: list[tuple[Array, Array, Array]] = []
    meshes = iter(contacts.corners)
    for kind, geoms in contacts.shapes:
        for geom in geoms:
            place, turn = data.geom_xpos[geom], data.geom_xmat[geom]
            size = jnp.asarray(model.geom_size[geom], place.dtype)
            radius, along = 0.0, jnp.array([0.0, 1.0, 0.0], place.dtype)
            if kind == SPHERE:
                points, radius = place[None], size[0]
            elif kind == CAPSULE:
                radius, along = size[0], turn[:, 2]
                points = place + jnp.array([[1.0], [-1.0]], place.dtype) * (size[1] * along)
            elif kind == ELLIPSOID:
                points = (place - turn @ (size * _unit(turn[2] * size)))[None]
            elif kind == CYLINDER:
                points = place + _rim(turn, size)
            elif kind == BOX:
                offset = (_CORNERS * size) @ turn.T
                points = place + jnp.where(offset[:, 2:] > 0.0, -offset, offset)
            else:
                points = place + jnp.asarray(next(meshes), place.dtype) @ turn.T
            num = points.shape[0]
            parts.append((points, jnp.full(num, radius), jnp.broadcast_to(along, (num, 3))))
    centre, radius, along = (jnp.concatenate(each) for each in zip(*parts, strict=True))
    return centre, radius, along


def _rim(turn: Float[Array, "3 3"], size: Any) -> Float[Array, "4 3"]:
    """Returns points on a cylinder's rims, from its centre: three of the lower one, one above."""
    axis = jnp.where(turn[2, 2] > 0.0, -turn[:, 2], turn[:, 2])
    down = jnp.array([0.0, 0.0, -1.0], turn.dtype)
    lean = down - axis * (axis @ down)
    steep = lean @ lean > _SMALL  # else a disk lies level, and all of its rim is as low
    lowest = size[0] * jnp.where(steep, _unit(lean), turn[:, 0])
    side = jnp.cross(lowest, axis) * np.sqrt(0.75).item()
    end = size[1] * axis
    return jnp.stack(
        [end + lowest, lowest - end, end + side - 0.5 * lowest, end - side - 0.5 * lowest]
    )


def _unit(vector: Float[Array, "3"]) -> Float[Array, "3"]:
    return vector * jax.lax.rsqrt(jnp.maximum(vector @ vector, _SMALL))
