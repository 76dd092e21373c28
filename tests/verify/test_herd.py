"""Tests of many walkers in one model of C MuJoCo."""

import numpy as np
import pytest
from verify.stepped import BODIES

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.verify.herd import Herd


@pytest.mark.parametrize("name", BODIES)
def test_walkers_of_a_herd_have_what_c_mujoco_gives_to_one(name: str) -> None:
    env = BODIES[name]
    herd, points = Herd(env.spec(), 3), env.anatomy.points
    rng = np.random.default_rng(6)
    herd.qpos[:], herd.qvel[:] = rng.normal(size=(2, *herd.qpos.shape))
    herd.see()
    names = [point.body for point in points]
    places = herd.data.xpos[herd.ids(*names)] + rng.normal(size=(len(points), 3))
    found = herd.jacobian(places, herd.moves(*names))
    for walker in range(3):
        one = mujoco.MjData(herd.model)
        one.qpos[:], one.qvel[:] = herd.qpos[walker], herd.qvel[walker]
        mujoco.mj_forward(herd.model, one)
        expected = np.zeros((3, herd.model.nv))
        for number, point in enumerate(points):
            body = herd.model.body(point.body).id
            mujoco.mj_jac(herd.model, one, expected, None, places[walker, number], body)
            np.testing.assert_allclose(found[walker, number], expected, atol=1e-12)
        bias = herd.of_joints("qfrc_bias")[walker]
        np.testing.assert_allclose(bias, one.qfrc_bias, atol=1e-9)
        np.testing.assert_allclose(herd.centre()[walker], one.subtree_com[1], atol=1e-12)
        mass = np.zeros((herd.model.nv, herd.model.nv))
        mujoco.mj_fullM(herd.model, one, mass)
        np.testing.assert_allclose(herd.mass()[walker], mass, atol=1e-12)
