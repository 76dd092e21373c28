"""Writes a file's meshes as hulls of few vertices, so that a body's text needs no other file."""

from typing import Any

import numpy as np
from jaxtyping import Float

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf.kept import Kept
from mjxwalk.envs.mjcf.writer import Shape

MOST = 64  # vertices of a hull that collides; ours: what feet have, and every one is in the text
MOST_DRAWN = 24  # vertices of a hull that is drawn alone; ours
# ours: how far a hull may fall short of its mesh, as a share of the mesh's size.
CLOSE, CLOSE_DRAWN = 1e-3, 0.03
_THIN = 1e-3  # a mesh is flat whose thickness is less than this share of its size; ours
_MESH = int(mujoco.mjtGeom.mjGEOM_MESH)


def shapes(kept: Kept) -> tuple[dict[int, Shape], dict[str, Float[np.ndarray, "vertex 3"]]]:
    """Returns what is written of each geom that is a mesh, and the vertices of each hull, m."""
    model = kept.model
    geoms = [
        geom
        for geom in range(model.ngeom)
        if int(model.geom_type[geom]) == _MESH and int(model.geom_bodyid[geom]) in kept.bodies
    ]
    collide = {int(model.geom_dataid[geom]) for geom in geoms if geom in kept.colliding}
    found: dict[int, Shape] = {}
    hulls: dict[str, Float[np.ndarray, "vertex 3"]] = {}
    for geom in geoms:
        mesh = int(model.geom_dataid[geom])
        pos, quat = np.array(model.geom_pos[geom]), np.array(model.geom_quat[geom])
        vertices = _vertices(model, mesh)
        middle, half = _box(vertices)
        size = float(half.max())
        if half.min() <= _THIN * size:
            turned = np.zeros(3)
            mujoco.mju_rotVecQuat(turned, middle, quat)
            found[geom] = Shape("box", tuple(np.maximum(half, _THIN * size)), pos + turned, quat)
            continue
        name = str(model.mesh(mesh).name) or f"mesh_{mesh}"
        if name not in hulls:
            most, close = (MOST, CLOSE) if mesh in collide else (MOST_DRAWN, CLOSE_DRAWN)
            hulls[name] = hull(vertices, most, close * 2.0 * size)
        found[geom] = Shape("mesh", (), pos, quat, name)
    return found, hulls


def hull(
    vertices: Float[np.ndarray, "all 3"], most: int, close: float
) -> Float[np.ndarray, "some 3"]:
    """Returns those of the vertices whose hull is nearest to the hull of all.

    Each next one is where the hull so far falls short the most.

    Args:
      vertices: of a mesh, m.
      most: of them that are taken.
      close: how far the hull may fall short, m; then no more are taken.
    """
    directions = _directions(600)  # ours: some 8 degrees apart
    reach = vertices @ directions.T
    best, farthest = np.argmax(reach, axis=0), np.max(reach, axis=0)
    # A tetrahedron first, so that what is taken encloses a volume.
    taken = _tetrahedron(vertices)
    while len(taken) < most:
        short = farthest - np.max(reach[taken], axis=0)
        worst = int(np.argmax(short))
        if short[worst] <= close:
            break
        taken.append(int(best[worst]))
    return np.array([[float(f"{value:.5g}") for value in vertices[each]] for each in taken])


def _tetrahedron(vertices: Float[np.ndarray, "all 3"]) -> list[int]:
    """Returns four vertices far from each other, of each three far from their plane."""
    first = int(np.argmax(np.linalg.norm(vertices - vertices.mean(axis=0), axis=1)))
    away = vertices - vertices[first]
    second = int(np.argmax(np.linalg.norm(away, axis=1)))
    along = away[second] / np.linalg.norm(away[second])
    third = int(np.argmax(np.linalg.norm(np.cross(away, along), axis=1)))
    normal = np.cross(along, away[third])
    fourth = int(np.argmax(np.abs(away @ normal)))
    return [first, second, third, fourth]


def _directions(num: int) -> Float[np.ndarray, "num 3"]:
    """Returns directions spread evenly, on a spiral from pole to pole."""
    height = 1.0 - (2.0 * np.arange(num) + 1.0) / num
    angle = np.arange(num) * np.pi * (3.0 - np.sqrt(5.0))
    radius = np.sqrt(1.0 - height**2)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)


def _vertices(model: Any, mesh: int) -> Float[np.ndarray, "vertex 3"]:
    """Returns the vertices of a mesh, or of its hull where MuJoCo has made one, m."""
    first, num = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    vertices = np.asarray(model.mesh_vert[first : first + num], np.float64)
    place = int(model.mesh_graphadr[mesh])
    if place < 0:
        return vertices
    num = int(model.mesh_graph[place])
    return vertices[model.mesh_graph[place + 2 + num : place + 2 + 2 * num]]


def _box(vertices: Float[np.ndarray, "vertex 3"]) -> tuple[Any, Any]:
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    return (low + high) / 2, (high - low) / 2
