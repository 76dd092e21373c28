"""Tests of walkers that plain `mj_step` moves, beside the engines' law of the same contacts."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from mujoco_bodies import SMALL

from mjxwalk import robots
from mjxwalk.engines import lanes
from mjxwalk.envs import TRIAL_AXES, Course, MjcfEnv, Payload, Push, Stretches
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import reader
from mjxwalk.envs.mujoco_law.settings import MujocoContact
from mjxwalk.verify import supported
from mjxwalk.verify.mj_step import MjStep

pytestmark = pytest.mark.usefixtures("unchecked_types")
BURDENS: dict[str, Any] = {
    "push": Push(speed=0.3, duration=0.0333, begin=0.0, every=0.1),
    "payload": Payload(share=0.2, spread=0.1, forward=-0.03, up=0.1),
}
ENV = MjcfEnv.of(SMALL, contact_law="mujoco", solver=MujocoContact(iterations=50), **BURDENS)


@pytest.mark.slow
def test_walkers_under_mujocos_contacts_move_alike() -> None:
    key = jax.random.key(1)
    trials = ENV.equipped(key, ENV.level_trials(3))
    given = trials.given(np.arange(3))
    start = jax.vmap(ENV.reset, in_axes=(TRIAL_AXES,))(given)
    values = 0.4 * np.sin(0.2 * np.arange(60))[:, None] * np.array([1.0, -1.0])

    def walk(state: Any, values: Any, given: Any) -> Any:
        return jax.lax.scan(lambda at, each: (ENV.step(at, each, given), at.qpos), state, values)

    axes = (0, None, TRIAL_AXES)
    last, _ = lanes.vmap(walk, axes)(start, values.astype(np.float32), given)
    reference = MjStep(ENV, start.qpos, start.qvel, trials)
    seen: Any = None  # of the last step
    for each in values:
        action = [np.tile(part, (3, 1)) for part in ENV.scaled_action(jnp.asarray(each))]
        seen = reference.step(action)
    # m and rad; float32 of a metre over some dozen steps that hit and let go
    np.testing.assert_allclose(last.qpos, reference.qpos, atol=1e-5)
    np.testing.assert_array_equal(last.touching, seen.push.touching)
    assert np.ptp(reference.qpos[:, 0]) > 1e-3  # pushes and payloads differ


def test_height_fields_lie_where_the_trials_ground_is() -> None:
    trials = ENV.level_trials(1)
    raised = trials._replace(heights=trials.heights + np.float32(0.05))
    start = jax.vmap(ENV.reset, in_axes=(TRIAL_AXES,))(raised.given(np.arange(1)))
    reference = MjStep(ENV, start.qpos, start.qvel, raised)
    seen: Any = None  # of the last step
    for _ in range(100):
        action = [np.array(part)[None] for part in ENV.scaled_action(jnp.zeros(2))]
        seen = reference.step(action)
    assert seen.push.touching.all()
    assert reference.qpos[0, 1] == pytest.approx(ENV.stance.height + 0.05, abs=0.003)


def test_other_soil_is_refused_by_name() -> None:
    supported.check("a walker", ENV)
    env = dataclasses.replace(ENV, course=Course(soft=Stretches(factor=0.5)))
    with pytest.raises(ValueError, match="no second law for soft and slippery ground under the"):
        supported.check("a walker", env)


def test_coordinates_of_a_body_in_space_come_back_from_mujocos() -> None:
    text = reader.read(robots.path("berkeley_humanoid")).text
    env = dataclasses.replace(MjcfEnv.of(text), contact_law="mujoco")
    rng = np.random.default_rng(4)
    trials, num = env.level_trials(5), len(env.stance.qpos)
    qpos = np.asarray(env.stance.qpos) + 0.3 * rng.normal(size=(5, num))
    qvel = rng.normal(size=(5, num))
    reference = MjStep(env, qpos, qvel, trials)
    for walker in range(5):
        data: Any = reference._datas[walker]  # pyright: ignore[reportPrivateUsage]
        back = reference._coordinates(data)  # pyright: ignore[reportPrivateUsage]
        np.testing.assert_allclose(back[0], qpos[walker], atol=1e-12)
        np.testing.assert_allclose(back[1], qvel[walker], atol=1e-12)
        # The torso moves as in the tree of the anatomy, whose root has yaw, pitch and roll.
        tree = env.model.mujoco
        there = mujoco.MjData(tree)
        there.qpos[:], there.qvel[:] = qpos[walker], qvel[walker]
        mujoco.mj_forward(tree, there)
        mujoco.mj_forward(reference._models[walker], data)  # pyright: ignore[reportPrivateUsage]
        foot, speeds = env.anatomy.legs[0].foot, []
        file_foot = foot.removesuffix("_left").removesuffix("_right")
        np.testing.assert_allclose(data.body(file_foot).xpos, there.body(foot).xpos, atol=1e-9)
        for model, at, name in (
            (reference._models[walker], data, file_foot),  # pyright: ignore[reportPrivateUsage]
            (tree, there, foot),
        ):
            velocity = np.zeros(6)
            number = model.body(name).id
            mujoco.mj_objectVelocity(model, at, int(mujoco.mjtObj.mjOBJ_BODY), number, velocity, 0)
            speeds.append(velocity[3:])
        np.testing.assert_allclose(speeds[-1], speeds[-2], atol=1e-9)
