"""Pairs of spheres and capsules that touch are those that C MuJoCo finds, as near as it says."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.engines import lanes
from mjxwalk.envs._mujoco import mjx, mujoco
from mjxwalk.envs.mujoco_law import own_pairs, softness
from mjxwalk.envs.mujoco_law.own_pairs import OwnPairs

pytestmark = pytest.mark.usefixtures("unchecked_types")
NUM, STATES = 8, 60
GEOM = '<body><freejoint/><geom type="{kind}" size="{size}" margin="{margin}" condim="1"/></body>'
KINDS = ("sphere", "capsule", "capsule", "sphere", "capsule", "sphere", "capsule", "sphere")


def body() -> tuple[Any, OwnPairs, Any]:
    """Returns a model of geoms that fly freely, their pairs, and MJX's model."""
    geoms = [
        GEOM.format(kind=kind, size=f"{0.03 + 0.01 * place} 0.2", margin=0.002 * place)
        for place, kind in enumerate(KINDS)
    ]
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{''.join(geoms)}</worldbody></mujoco>"
    )
    ours = mjx.put_model(model)
    (pairs,) = own_pairs.find(model, ours, mjx.make_data(model))
    return model, pairs, ours


def states(model: Any) -> Any:
    """Returns positions of geoms that lie about each other."""
    rng = np.random.default_rng(0)
    qpos = rng.normal(size=(STATES, NUM, 7))
    qpos[:, :, :3] = rng.uniform(-0.35, 0.35, size=(STATES, NUM, 3))
    qpos[:, :, 3:] /= np.linalg.norm(qpos[:, :, 3:], axis=-1, keepdims=True)
    return qpos.reshape(STATES, model.nq).astype(np.float32)


def test_slots_hold_the_pairs_that_touch_as_c_mujoco_has_them() -> None:
    model, pairs, ours = body()
    start = mjx.make_data(model)

    def found(qpos: Any) -> Any:
        data = mjx.kinematics(ours, start.replace(qpos=qpos))
        shares = own_pairs.touching(pairs, data)
        return [(slots, own_pairs.touches(pairs, slots, data)) for slots in shares]

    qpos = states(model)
    shares = jax.tree.map(np.asarray, lanes.vmap(found)(qpos))
    data, counts = mujoco.MjData(model), []
    for state in range(STATES):
        data.qpos[:] = qpos[state]
        mujoco.mj_forward(model, data)
        expected = {tuple(each.geom): each for each in data.contact}
        seen: set[Any] = set()
        for slots, touches in shares:
            for slot in np.flatnonzero(slots.filled[state]):
                key = tuple(pairs.geom[slots.pair[state, slot]])
                seen.add(key)
                contact = expected[key]
                frame = contact.frame.reshape(3, 3)
                # float32 of a metre; normals are differences over some centimetres.
                assert touches.distance[state, slot] == pytest.approx(contact.dist, abs=1e-6)
                np.testing.assert_allclose(touches.place[state, slot], contact.pos, atol=2e-5)
                np.testing.assert_allclose(touches.frame[state, slot][0], frame[0], atol=1e-4)
        assert seen == set(expected)
        counts.append(len(expected))
    # Every share is taken, and none is too small.
    assert 0 in counts
    assert sum(own_pairs.SHARES[:2]) < max(counts) <= sum(own_pairs.SHARES)


def test_tables_of_constants_are_looked_up_only_where_rows_differ() -> None:
    table = np.array([[1.0, 2.0], [1.0, 3.0]])
    for row in (0, 1):
        np.testing.assert_array_equal(softness.picked(table, jnp.asarray(row)), table[row])
    assert isinstance(softness.picked(table[:, :1], jnp.asarray(0)), np.ndarray)
