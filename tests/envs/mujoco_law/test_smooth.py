"""Mass matrices and forces of motion are C MuJoCo's, of bodies with every kind of joint."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from c_contacts import model_of, text_of

from mjxwalk.engines import lanes
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.dynamics import PointMass
from mjxwalk.envs.mujoco_law import layout, smooth, tree, tree_data
from mjxwalk.envs.mujoco_law.layout import Layout

# A step is traced some times as fast.
pytestmark = pytest.mark.usefixtures("unchecked_types")
# Of the largest number: float32 has seven digits, of which sums along a tree take one.
CLOSE = 2e-6
BALLS = """
<mujoco>
  <worldbody>
    <body pos="0.1 0.2 1" quat="0.9 0.1 0.3 -0.2">
      <freejoint/>
      <geom type="box" size="0.1 0.2 0.3" pos="0.05 0.02 0.1" euler="10 20 30"/>
      <body pos="0.3 0 0.1" quat="0.5 0.5 -0.5 0.5">
        <joint type="ball" pos="0.02 0 0.03"/>
        <geom type="capsule" fromto="0 0 0 0.3 0.1 0" size="0.05"/>
        <body pos="0.3 0.1 0" euler="0 0 40">
          <geom type="sphere" size="0.1" pos="0 0.05 0"/>
          <body pos="0.1 0 0">
            <joint type="slide" axis="1 2 2" pos="0.1 0 0"/>
            <joint axis="0.6 0 0.8" pos="0 0.1 0.05"/>
            <joint axis="0 -1 0" ref="20" pos="0.05 0 0"/>
            <geom type="box" size="0.05 0.1 0.02"/>
          </body>
        </body>
      </body>
      <body pos="-0.2 0 0"><joint axis="0 1 0"/><geom type="capsule" size="0.05 0.2"/></body>
    </body>
  </worldbody>
</mujoco>
"""
NAMES = ["balls", "h1", "small, tied"]


class Seen:
    """A body in some states, as C MuJoCo sees it in float64."""

    def __init__(self, name: str, states: int = 4) -> None:
        text = BALLS if name == "balls" else text_of(name)
        is_ours = name == "balls"
        self.model: Any = mujoco.MjModel.from_xml_string(text) if is_ours else model_of(text).mujoco
        self.layout: Layout = layout.of_model(self.model)
        self.qpos, self.qvel, self.bias, self.mass = [], [], [], []
        data, rng = mujoco.MjData(self.model), np.random.default_rng(0)
        for _ in range(states):
            mujoco.mj_resetData(self.model, data)
            mujoco.mj_integratePos(self.model, data.qpos, rng.normal(size=self.model.nv), 1.0)
            data.qvel[:] = rng.normal(size=self.model.nv)
            self.forward(data)

    def forward(self, data: Any) -> None:
        mujoco.mj_forward(self.model, data)
        mass = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, data, mass)
        self.qpos.append(data.qpos.astype(np.float32))
        self.qvel.append(data.qvel.astype(np.float32))
        self.bias.append(data.qfrc_bias.copy())
        self.mass.append(mass - np.diag(self.model.dof_armature))

    def check(self, carried: PointMass | None = None) -> None:
        """Raises unless our mass matrix and force of motion are C MuJoCo's."""

        def ours(qpos: Any, qvel: Any) -> Any:
            at = tree.of_positions(self.layout, qpos)
            masses = smooth.masses(at)
            if carried is not None:
                masses = smooth.with_mass(at, masses, carried)
            rates, still = tree.about_world(at, qvel), jnp.zeros_like(qvel)
            gravity = np.array(self.model.opt.gravity)
            force = smooth.force_of_motion(at, masses, rates, still, gravity)
            matrix = smooth.mass_matrix(at, masses)
            turned = jax.vmap(lambda row: tree.about_root(at, row))
            return turned(turned(matrix).T), tree.about_root(at, force)

        mass, force = lanes.vmap(ours)(np.stack(self.qpos), np.stack(self.qvel))
        for found, expected in ((mass, self.mass), (force, self.bias)):
            expected = np.stack(expected)
            np.testing.assert_allclose(found, expected, rtol=0, atol=CLOSE * np.abs(expected).max())


@pytest.mark.parametrize("name", NAMES)
def test_mass_matrix_and_force_of_motion_are_c_mujocos(name: str) -> None:
    Seen(name).check()


def test_a_point_mass_counts_where_it_is_carried() -> None:
    seen = Seen("balls")
    body, place = 3, np.array([0.1, -0.2, 0.05])
    seen.model = mujoco.MjModel.from_xml_string(
        BALLS.replace(
            '<geom type="sphere"',
            '<body pos="0.1 -0.2 0.05">'
            '<inertial pos="0 0 0" mass="2" diaginertia="1e-9 1e-9 1e-9"/></body>'
            '<geom type="sphere"',
        )
    )
    data, states = mujoco.MjData(seen.model), list(zip(seen.qpos, seen.qvel, strict=True))
    seen.qpos, seen.qvel, seen.bias, seen.mass = [], [], [], []
    for qpos, qvel in states:
        data.qpos[:], data.qvel[:] = qpos, qvel
        seen.forward(data)
    seen.check(PointMass(body, place, jnp.asarray(2.0)))
    with pytest.raises(AssertionError):
        seen.check()


def test_places_velocities_and_inertias_about_the_centre_are_c_mujocos() -> None:
    site = '<site pos="0.1 0.2 0.3" euler="10 20 30"/><body name="leg_left"'
    model = model_of(text_of("small, tied").replace('<body name="leg_left"', site))
    found, data, rng = model.mujoco, mujoco.MjData(model.mujoco), np.random.default_rng(0)
    data.qpos[:], data.qvel[:] = rng.normal(size=(2, found.nv)).astype(np.float32)
    mujoco.mj_forward(found, data)

    def ours(qpos: Any, qvel: Any) -> Any:
        at = tree.of_positions(model.layout, qpos)
        seen = tree_data.of_tree(model, at, qpos, tree.about_world(at, qvel))
        about = tree_data.about_centre(model, seen)
        return (
            *(getattr(seen, name) for name in ("xpos", "xmat", "xipos", "ximat", "ten_length")),
            *(getattr(seen, name) for name in ("geom_xpos", "geom_xmat", "site_xpos")),
            *(about.subtree_com, about.cvel, about._impl.cinert),
        )

    values = jax.jit(ours)(data.qpos.astype(np.float32), data.qvel.astype(np.float32))
    names = "xpos xmat xipos ximat ten_length geom_xpos geom_xmat site_xpos subtree_com cvel cinert"
    for name, value in zip(names.split(), values, strict=True):
        expected = np.asarray(getattr(data, name))
        # Of the world itself MJX has no velocity and inertia.
        skip = 1 if name in ("subtree_com", "cvel", "cinert") else 0
        np.testing.assert_allclose(
            np.asarray(value).reshape(expected.shape)[skip:], expected[skip:],
            atol=CLOSE * max(1.0, np.abs(expected).max()), err_msg=name,
        )  # fmt: skip
