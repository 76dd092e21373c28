"""Our tasks are Gymnasium's: steps, starts, settings and ends, against C MuJoCo in float64."""

import functools
import inspect
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium
import gymnasium_tasks
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from gymnasium_tasks import single, stepping

from mjxwalk.engines import lanes
from mjxwalk.envs import TRIAL_AXES, Trial
from mjxwalk.envs.gymnasium import TASKS, Walker2d, files
from mjxwalk.envs.terrain import Terrain

# A step is traced some times as fast.
pytestmark = pytest.mark.usefixtures("unchecked_types")
ALL = [
    "Walker2d-v5",
    "HalfCheetah-v5",
    *(pytest.param(name, marks=pytest.mark.slow) for name in ("Hopper-v5", "Ant-v5")),
    pytest.param("Humanoid-v5", marks=pytest.mark.slow),
]


@functools.cache
def compiled(name: str) -> Any:
    """Returns our step of a task with its observation, compiled."""
    task = TASKS[name]()
    step = stepping(task)

    def observed(state: Any, action: Any) -> Any:
        after = step(state, action)
        return after, task.observe(after)

    return lanes.vmap(observed, (0, 0))


@pytest.mark.parametrize("name", ALL)
def test_a_float32_control_step_agrees_with_gymnasium(name: str) -> None:
    """Each state is Gymnasium's, with actions as large as they may be.

    A control step is twenty evaluations of forces of up to some thousand N and N m. Six digits of
    accelerations of some thousand rad/s^2 for 10 ms are 1e-5 rad/s. What
    comes within reach of the floor in one and not yet in the other, for a step of the physics,
    makes a hundred of those; in a state of three hundred it does. Parts of a body touch each other
    where MJX has their nearest points, to five digits; forces have four.
    """
    given = gymnasium_tasks.steps(TASKS[name](), episodes=6, length=60, scale=1.0)
    after, observation = compiled(name)(*single((given.before, given.action)))
    moved = np.concatenate(
        [
            np.abs(after.qpos - given.qpos) / 1e-5,
            np.abs(after.qvel - given.qvel) / 1e-3,
            np.abs(after.total - given.reward)[:, None] / 1e-4,
        ],
        axis=1,
    ).max(1)
    assert np.mean(moved < 1.0) >= 0.99
    assert moved.max() < 100.0
    largest = np.abs(given.observation).max(1)
    seen = np.abs(observation - given.observation).max(1) / (1e-3 + 1e-4 * largest)
    assert np.mean(seen < 1.0) >= 0.99
    np.testing.assert_array_equal(after.trial.fell, given.terminated)
    if name != "HalfCheetah-v5":
        assert 0 < given.terminated.sum() < len(given.terminated)


# Steps of control until contacts, which grow a difference like any chaos, have grown the rounding
# of float32 to a hundredth of what is allowed of the median: Ant stands on four feet.
@pytest.mark.parametrize(
    ("name", "length"),
    [
        ("Walker2d-v5", 100),
        ("HalfCheetah-v5", 100),
        pytest.param("Hopper-v5", 100, marks=pytest.mark.slow),
        pytest.param("Ant-v5", 30, marks=pytest.mark.slow),
        pytest.param("Humanoid-v5", 30, marks=pytest.mark.slow),
    ],
)
def test_a_float32_walk_stays_with_gymnasiums(name: str, length: int) -> None:
    given = gymnasium_tasks.parallel(TASKS[name](), episodes=16, length=length, scale=0.1)
    state = single(jax.tree.map(lambda leaf: leaf[0], given.before))
    for action in given.action:
        state, _ = compiled(name)(state, single(action))
    off = np.abs(np.asarray(state.qpos) - given.qpos[-1]).max(1)
    assert np.median(off) < 1e-4
    assert np.median(np.abs(np.asarray(state.total) - given.reward.sum(0))) < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Walker2d-v5", "HalfCheetah-v5"])
def test_a_float64_walk_agrees_with_gymnasiums_to_its_last_digits(name: str) -> None:
    """What sets a walk in float32 apart is rounding alone."""
    environment = {
        **os.environ,
        "JAX_ENABLE_X64": "1",
        "PYTHONPATH": str(Path(gymnasium_tasks.__file__).parent),
    }
    told = subprocess.run(
        [sys.executable, gymnasium_tasks.__file__, name],
        env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert float(told.stdout.split()[-1]) < 1e-10


@pytest.mark.parametrize("name", TASKS)
def test_the_first_observation_is_gymnasiums(name: str) -> None:
    task, env = TASKS[name](), gymnasium.make(name).unwrapped
    expected, _ = env.reset(seed=3)
    model: Any = env.model  # type: ignore[attr-defined]
    data: Any = env.data  # type: ignore[attr-defined]
    noise = np.concatenate([data.qpos - model.qpos0, data.qvel]) / task.reset_noise_scale

    def observed(start: Any) -> Any:
        state = task.reset(Trial(Terrain(jnp.zeros((1, 1)), jnp.zeros((), int)), start))
        return state.qpos[0], task.observe(state)

    forward, observation = jax.jit(observed)(jnp.asarray(noise))
    assert float(forward) == 0.0  # where along x is not observed
    np.testing.assert_allclose(observation, expected, atol=1e-5, rtol=1e-5)
    assert len(set(task.observation_names)) == len(expected)
    assert len(task.action_names) == model.nu


@pytest.mark.parametrize("name", TASKS)
def test_settings_are_gymnasiums_by_default(name: str) -> None:
    task = TASKS[name]()
    theirs = inspect.signature(type(gymnasium.make(name).unwrapped)).parameters
    ours = {setting: each.default for setting, each in theirs.items() if hasattr(task, setting)}
    assert {"frame_skip", "ctrl_cost_weight", "reset_noise_scale"} <= ours.keys()
    for setting, value in ours.items():
        # A setting is a number; 1e10 stands for no end.
        assert getattr(task, setting) == pytest.approx(np.clip(value, -1e10, 1e10).tolist())
    spec = gymnasium.spec(name)
    assert task.max_steps == spec.max_episode_steps


@pytest.mark.parametrize("name", TASKS)
def test_a_body_weighs_and_moves_as_gymnasiums_file_says(name: str) -> None:
    task = TASKS[name]()
    theirs: Any = gymnasium.make(name).unwrapped
    ours = task.model.law.mujoco
    fields = [
        each
        for kind in ("body", "jnt", "dof", "geom", "tendon")
        for each in dir(ours)
        if each.startswith(f"{kind}_") and not each.endswith(("adr", "matid", "user"))
    ]
    assert len(fields) > 50
    for field in [each for each in fields if isinstance(getattr(ours, each), np.ndarray)]:
        np.testing.assert_array_equal(getattr(ours, field), getattr(theirs.model, field), field)
    assert task.timestep == pytest.approx(theirs.dt)
    np.testing.assert_array_equal(task.model.gear, theirs.model.actuator_gear[:, 0])


def standing(name: str) -> Any:
    """Returns the state of four bodies at the start, and an action of nothing."""
    task = TASKS[name]()
    trials = task.sample_trials(jax.random.key(0), 4)
    reset = jax.jit(jax.vmap(task.reset, in_axes=(TRIAL_AXES,)))
    state = jax.tree.map(np.array, reset(trials.given(np.arange(4))))
    return state, np.zeros((4, len(task.action_names)), np.float32)


def test_a_trial_ends_after_its_last_step_without_a_fall() -> None:
    state, action = standing("Walker2d-v5")
    steps = np.array([0, 997, 998, 999], np.int32)
    after, _ = compiled("Walker2d-v5")(
        state._replace(trial=state.trial._replace(num_steps=steps)), action
    )
    np.testing.assert_array_equal(after.trial.num_steps, steps + 1)
    np.testing.assert_array_equal(after.trial.done, [False, False, False, True])
    assert not after.trial.fell.any()


def test_what_diverges_leaves_the_last_sound_state() -> None:
    state, action = standing("HalfCheetah-v5")
    action[1], action[2] = np.nan, 1e30
    after, _ = compiled("HalfCheetah-v5")(state, action)
    np.testing.assert_array_equal(after.trial.diverged, [False, True, False, False])
    np.testing.assert_array_equal(after.trial.done, [False, True, False, False])
    np.testing.assert_array_equal(after.qpos[1], state.qpos[1])
    assert after.total[1] == 0.0
    assert after.total[2] < -1e20  # it costs what was asked, and moves as it can
    assert np.isfinite(after.qvel).all()


def test_motors_give_torque_and_work() -> None:
    state, action = standing("HalfCheetah-v5")
    action[:] = 0.5
    after, _ = compiled("HalfCheetah-v5")(state, action)
    gear = TASKS["HalfCheetah-v5"]().model.gear
    np.testing.assert_allclose(after.trial.torque_cost, 0.05 * 0.5 * gear.sum(), rtol=1e-5)
    assert (after.trial.work > 0.0).all()


@pytest.mark.parametrize(("name", "normal"), [("Walker2d-v5", False), ("HalfCheetah-v5", True)])
def test_starts_are_drawn_as_gymnasiums(name: str, normal: bool) -> None:
    task = TASKS[name]()
    start = np.asarray(task.sample_trials(jax.random.key(1), 4000).start)
    places, rates = start[:, :9], start[:, 9:]
    assert np.abs(places).max() <= 1.0
    np.testing.assert_allclose(places.std(0), 1.0 / np.sqrt(3.0), atol=0.02)
    np.testing.assert_allclose(rates.std(0), 1.0 if normal else 1.0 / np.sqrt(3.0), atol=0.05)
    assert (np.abs(rates).max() > 1.0) == normal
    again = task.sample_trials(jax.random.key(2), 4000).start
    assert not np.array_equal(start, again)


def test_without_gymnasium_a_sentence_says_what_to_install(monkeypatch: Any) -> None:
    text = Walker2d().body
    monkeypatch.setattr(files.importlib.util, "find_spec", lambda name: None)
    files.text.cache_clear()
    with pytest.raises(ValueError, match=r"^Walker2d-v5 takes its body from gymnasium, .*install"):
        _ = Walker2d().observation_names
    assert Walker2d(body=text).observation_names  # a run has the text
    files.text.cache_clear()


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"frame_skip": 0}, "frame_skip must be from 1"),
        ({"healthy_z_range": (2.0, 0.8)}, "healthy_z_range must be two numbers that rise"),
        ({"integrator": "verlet"}, 'integrator must be "file"'),
        ({"iterations": 0}, "iterations must be from 1"),
        ({"reset_noise_scale": -1.0}, "reset_noise_scale must be 0 or above"),
        ({"body": "<mujoco><include file='x'/></mujoco>"}, "may have no <include>"),
    ],
)
def test_wrong_settings_are_refused(settings: Any, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        Walker2d(**settings)


def test_an_action_of_another_shape_is_refused() -> None:
    state, _ = standing("Walker2d-v5")
    with pytest.raises(ValueError, match=r"action must have shape \(6,\), got \(5,\)"):
        stepping(Walker2d())(jax.tree.map(lambda leaf: leaf[0], state), np.zeros(5))
