"""Where a body may touch the ground: points on the surfaces of its geoms."""

import re
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.envs import frames
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.derived.source import PLANE, Pose, geoms_of

MOST = 8  # points of a foot; ours: each costs some 150 operations a step
SITES = re.compile(r"(?i)(^|[_\W])(heel|toe|sole|ball|contact|corner|cp)(?=[_\W\d]|$)")
SAME = 1e-3  # m; points nearer to each other than this are one
# ours: directions up from the ground for a foot that is tilted, by how far and to where, rad.
TILTS = np.radians([5.0, 20.0, 40.0, 60.0])
TURNS = (np.arange(64) + 0.5) * (2 * np.pi / 64)
_GEOM = mujoco.mjtGeom


class Point(NamedTuple):
    """A point that touches the ground.

    Attributes:
      name: of it.
      body: number of its body in the file's model.
      offset: from the body's origin in its axes, m.
      radius: of a sphere about the point, whose lowest point it is that touches, m.
      height: of what touches, in the pose that trials start in, m.
    """

    name: str
    body: int
    offset: Float[np.ndarray, "3"]
    radius: float
    height: float


def of_geom(pose: Pose, geom: int) -> list[tuple[Float[np.ndarray, "3"], float, float]]:
    """Returns the points of a geom: place in its body, m; radius, m; height of what touches, m."""
    model, data = pose
    size, kind = model.geom_size[geom], int(model.geom_type[geom])
    turn, radius = frames.matrix(model.geom_quat[geom]), 0.0
    if kind == int(_GEOM.mjGEOM_SPHERE):
        local, radius = np.zeros((1, 3)), float(size[0])
    elif kind == int(_GEOM.mjGEOM_CAPSULE):
        local, radius = np.array([[0, 0, size[1]], [0, 0, -size[1]]]), float(size[0])
    elif kind == int(_GEOM.mjGEOM_ELLIPSOID):
        # ours: a capsule along its longest axis, as thick as the thinnest.
        along = int(np.argmax(size))
        radius = float(size.min())
        local = np.array([1.0, -1.0])[:, None] * np.eye(3)[along] * (size[along] - radius)
    elif kind == int(_GEOM.mjGEOM_CYLINDER):
        ring = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]]) * size[0]
        local = np.array([[x, y, z] for x, y in ring for z in (-size[1], size[1])])
    elif kind == int(_GEOM.mjGEOM_BOX):
        ends = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        local = ends * size
    elif kind == int(_GEOM.mjGEOM_MESH):
        mesh = int(model.geom_dataid[geom])
        first, num = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        local = np.asarray(model.mesh_vert[first : first + num], np.float64)
    else:
        return []
    places = model.geom_pos[geom] + local @ turn.T
    body = int(model.geom_bodyid[geom])
    world = data.xpos[body] + places @ data.xmat[body].reshape(3, 3).T
    return [
        (place, radius, float(z) - radius) for place, z in zip(places, world[:, 2], strict=True)
    ]


def may_touch(model: Any, geom: int) -> bool:
    """Returns whether a geom collides with the file's floor, or with one that a file may have."""
    body = int(model.geom_bodyid[geom])
    if not body or int(model.geom_type[geom]) == PLANE:
        return False
    kind, takes = int(model.geom_contype[geom]), int(model.geom_conaffinity[geom])
    excluded = body in list(model.exclude_signature)  # by <exclude> with the world, which is body 0
    floors = [each for each in geoms_of(model, 0) if int(model.geom_type[each]) == PLANE]
    if not floors:  # one as MuJoCo has it where nothing is said of it
        return bool((kind | takes) & 1) and not excluded
    pairs = list(zip(model.pair_geom1, model.pair_geom2, strict=True))
    return any(
        not excluded
        and (kind & int(model.geom_conaffinity[floor]) or int(model.geom_contype[floor]) & takes)
        or (geom, floor) in pairs
        or (floor, geom) in pairs
        for floor in floors
    )


def friction_of(model: Any, bodies: list[int]) -> float:
    """Returns the least friction coefficient of a foot's geoms that may touch the ground.

    It is MuJoCo's usual one where none of them may.
    """
    found = [
        float(model.geom_friction[geom][0])
        for body in bodies
        for geom in geoms_of(model, body)
        if may_touch(model, geom)
    ]
    return min(found, default=1.0)


def of_foot(pose: Pose, bodies: list[int], *, planar: bool, reach: float) -> list[Point]:
    """Returns the points of a foot: its sites that are named so, or points of its geoms.

    Sites are taken where they are enough to stand on: two in the plane, three in space.

    Args:
      pose: that trials start in.
      bodies: of the foot.
      planar: whether the body moves in the plane, where points behind each other are one.
      reach: how far above the lowest a point may be, m.
    """
    sites = _sites(pose, bodies)
    if len(sites) >= (2 if planar else 3):
        return sites
    found: list[Point] = []
    for body in bodies:
        geoms = list(geoms_of(pose.model, body))
        colliding = [geom for geom in geoms if may_touch(pose.model, geom)]
        for geom in colliding or geoms:
            found += lower(pose, geom)
    low = min(point.height for point in found)
    found = _apart([each for each in found if each.height < low + reach], planar)
    return spread(_outer(pose, found, planar))


def _sites(pose: Pose, bodies: list[int]) -> list[Point]:
    model, data = pose
    return [
        Point(
            str(model.site(site).name),
            int(model.site_bodyid[site]),
            np.array(model.site_pos[site]),
            0.0,
            float(data.site_xpos[site][2]) if data.site_xpos.any() else 0.0,
        )
        for site in range(model.nsite)
        if int(model.site_bodyid[site]) in bodies and SITES.search(str(model.site(site).name))
    ]


def lower(pose: Pose, geom: int) -> list[Point]:
    """Returns the points of a geom, of those with corners the lower half."""
    model = pose.model
    body = int(model.geom_bodyid[geom])
    number = geom - int(model.body_geomadr[body])
    name = str(model.geom(geom).name) or f"{model.body(body).name}_geom{number or ''}"
    points = of_geom(pose, geom)
    heights = np.array([height for _, _, height in points])
    if len(points) > 2:
        middle = 0.5 * (heights.min() + heights.max())
        points = [each for each in points if each[2] <= middle]
    return [
        Point(f"{name}_{number}", body, place, radius, height)
        for number, (place, radius, height) in enumerate(points)
    ]


def _apart(points: list[Point], planar: bool) -> list[Point]:
    """Returns points that differ in place, lowest first."""
    kept: list[Point] = []
    for point in sorted(points, key=lambda each: each.height):
        gaps = [each.offset - point.offset for each in kept if each.body == point.body]
        if planar:
            gaps = [gap * np.array([1.0, 0.0, 1.0]) for gap in gaps]
        if all(np.linalg.norm(gap) > SAME for gap in gaps):
            kept.append(point)
    return kept


def _outer(pose: Pose, points: list[Point], planar: bool) -> list[Point]:
    """Returns the points that are the lowest of their body in some tilt, and inside no other."""
    tilts = np.concatenate([TILTS, -TILTS])
    if planar:
        upward = np.stack([np.sin(tilts), 0.0 * tilts, np.cos(tilts)], axis=-1)
    else:
        tilt, turn = (each.reshape(-1) for each in np.meshgrid(TILTS, TURNS))
        upward = np.stack(
            [np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)], axis=-1
        )
    axes = {point.body: pose.data.xmat[point.body].reshape(3, 3) for point in points}
    places = [pose.data.xpos[each.body] + axes[each.body] @ each.offset for each in points]
    lows = [upward @ place - each.radius for place, each in zip(places, points, strict=True)]

    def counts(one: int) -> bool:
        point = points[one]
        others = [low for low, each in zip(lows, points, strict=True) if each.body == point.body]
        inside = any(
            np.linalg.norm(place - places[one]) < each.radius - point.radius
            for place, each in zip(places, points, strict=True)
        )
        return not inside and bool(np.any(lows[one] <= np.min(others, axis=0)))

    return [point for number, point in enumerate(points) if counts(number)]


def spread(points: list[Point]) -> list[Point]:
    """Returns at most `MOST` points, each as far from those before it as it can be."""
    if len(points) <= MOST:
        return points
    kept, rest = [points[0]], points[1:]
    while len(kept) < MOST:
        far = [min(np.linalg.norm(each.offset - one.offset) for one in kept) for each in rest]
        kept.append(rest.pop(int(np.argmax(far))))
    return kept
