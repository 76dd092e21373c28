"""Tests of the hulls that meshes are written as."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import meshes as mjcf_meshes
from mjxwalk.envs.mjcf import reader

# A robot hand with meshes that MJX brings for its own tests.
HAND = Path(mujoco.__file__).parent / "mjx/test_data/shadow_hand/right_hand.xml"
CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-2, 2) for z in (-3, 3)], float)


def test_a_box_among_many_points_is_its_corners() -> None:
    inside = np.random.default_rng(0).uniform(-0.99, 0.99, (500, 3)) * [1, 2, 3]
    found = mjcf_meshes.hull(np.concatenate([inside, CORNERS]), 64, 1e-3)
    assert sorted(map(tuple, found)) == sorted(map(tuple, CORNERS))


def test_a_hull_has_no_more_vertices_than_it_may() -> None:
    points = np.random.default_rng(0).normal(size=(2000, 3))
    ball = points / np.linalg.norm(points, axis=1)[:, None]
    found = mjcf_meshes.hull(ball, 40, 0.0)
    assert len(found) == 40
    # 40 caps that cover the sphere evenly have a half angle of 18 degrees and a depth of 5 %.
    directions = np.random.default_rng(1).normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    assert np.max(1.0 - np.max(found @ directions.T, axis=0)) < 0.15


def reaches(model: Any, geom: int, directions: Any) -> Any:
    """Returns how far a mesh reaches in directions of its body, m."""
    mesh = int(model.geom_dataid[geom])
    first, num = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    vertices = model.mesh_vert[first : first + num] @ turn.reshape(3, 3).T + model.geom_pos[geom]
    return np.max(vertices @ directions.T, axis=0)


def test_hulls_lie_where_the_meshes_of_a_file_do() -> None:
    of_file = mujoco.MjModel.from_xml_path(str(HAND))
    of_text = mujoco.MjModel.from_xml_string(reader.read(HAND).text)
    assert of_text.ngeom == of_file.ngeom and of_text.nmesh > 10
    directions = np.random.default_rng(0).normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    meshes = np.flatnonzero(of_text.geom_type == mujoco.mjtGeom.mjGEOM_MESH)
    for geom in meshes:
        whole, hull = (reaches(model, int(geom), directions) for model in (of_file, of_text))
        size = np.max(np.abs(whole))
        collides = of_file.geom_contype[geom] or of_file.geom_conaffinity[geom]
        # Directions between those that hulls are fitted along may fall somewhat more short.
        close = 0.02 if collides else 0.1
        np.testing.assert_array_less(np.abs(whole - hull), close * size)
    np.testing.assert_allclose(of_text.body_mass, of_file.body_mass)


FLAT = """<mujoco>
  <asset><mesh name="sheet" inertia="shell" vertex="0 0 0 1 0 0 0 1 0 1 1 0"
    face="0 1 2 1 3 2"/></asset>
  <worldbody>
    <body><freejoint/><geom size="0.1"/><geom type="mesh" mesh="sheet" contype="0"
      conaffinity="0" mass="0"/></body>
  </worldbody>
</mujoco>
"""


def test_a_flat_mesh_is_a_thin_box(tmp_path: Path) -> None:
    path = tmp_path / "flat.xml"
    path.write_text(FLAT)
    model = mujoco.MjModel.from_xml_string(reader.read(path).text)
    assert model.geom_type[1] == mujoco.mjtGeom.mjGEOM_BOX
    np.testing.assert_allclose(np.sort(model.geom_size[1]), [5e-4, 0.5, 0.5], rtol=1e-5)
    np.testing.assert_allclose(model.geom_pos[1], [0.5, 0.5, 0.0], atol=1e-6)


def test_a_flat_mesh_that_collides_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "flat.xml"
    path.write_text(FLAT.replace('contype="0"', 'contype="1"'))
    with pytest.raises(ValueError, match="line 2: the mesh sheet is flat, and cannot collide"):
        reader.read(path)
