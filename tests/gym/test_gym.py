"""Tests of our bodies as tasks: gymnasium's own checks, and that one, many and ours agree."""

from typing import Any

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from gymnasium.utils import env_checker

import mjxwalk.gym
from mjxwalk.envs import Action, Flame, Planar7, Reil
from mjxwalk.errors import RunError
from mjxwalk.gym import MjxEnv, environments
from mjxwalk.pictures import offscreen


@pytest.fixture(scope="module")
def planar() -> Any:
    """Returns the planar environment, compiled once."""
    return gymnasium.make("mjxwalk/Planar7-v0")


def functions(env: Any) -> tuple[Any, Any]:
    """Returns reset and step as the environment has compiled them."""
    return environments._compiled(env.unwrapped.task.env)  # pyright: ignore[reportPrivateUsage]


def test_gymnasiums_checker_passes(planar: Any) -> None:
    env_checker.check_env(planar.unwrapped, skip_render_check=True)


@pytest.mark.slow
def test_gymnasiums_checker_passes_in_space() -> None:
    env = gymnasium.make("mjxwalk/Flame-v0")
    env_checker.check_env(env.unwrapped, skip_render_check=True)


def test_the_return_is_the_distance_and_a_fall_ends_the_trial(planar: Any) -> None:
    first, _ = planar.reset(seed=3)
    total, number, terminated, truncated, told = 0.0, 0, False, False, {"distance_m": 0.0}
    while not (terminated or truncated) and number < 400:
        obs, reward, terminated, truncated, told = planar.step(np.zeros(6, np.float32))
        assert planar.observation_space.contains(obs)
        total, number = total + reward, number + 1
    assert terminated and not truncated  # who does nothing falls
    assert 10 < number < 300
    assert told["fell"] == 1.0
    assert total == pytest.approx(told["distance_m"], abs=1e-5)
    again, _ = planar.reset(seed=3)
    np.testing.assert_array_equal(first, again)


@pytest.mark.slow
def test_a_step_is_as_many_steps_of_the_body(planar: Any) -> None:
    task = planar.unwrapped.task
    reset, compiled = functions(planar)
    state = reset(jax.random.key(1))
    push = jnp.array([0.3, -0.2, 0.1, -0.4, 0.9, 0.5])
    after = compiled(state, push)
    body, nothing = task.env, jnp.zeros(6)
    given = state.info["trials"].given(state.info["row"])
    action = Action(300.0 * push, nothing, nothing, jnp.full(6, 2.0))
    data, step = state.data, jax.jit(body.step)
    for _ in range(10):
        data = step(data, action, given)
    np.testing.assert_allclose(after.data.qpos, data.qpos, atol=1e-5)
    assert float(after.reward) == pytest.approx(float(data.qpos[0] - state.data.qpos[0]), abs=1e-6)


@pytest.mark.slow
def test_many_walkers_do_what_one_does_and_start_anew(planar: Any) -> None:
    many: Any = gymnasium.make_vec(
        "mjxwalk/Planar7-v0", num_envs=3, vectorization_mode="vector_entry_point"
    )
    obs, _ = many.reset(seed=0)
    assert many.observation_space.contains(obs)
    actions = np.zeros((3, 6), np.float32)
    actions[1] = 0.02
    reset, step = functions(planar)
    alone = reset(jax.random.key(0))
    for _ in range(5):  # the ground is level at first, so that all terrains are alike
        obs = many.step(actions)[0]
        alone = step(alone, jnp.asarray(actions[1]))
        np.testing.assert_allclose(obs[1], alone.obs, atol=1e-4)
    ended = np.zeros(3, bool)
    while not ended.any():
        _, _, terminated, truncated, _ = many.step(actions)
        ended = terminated | truncated
    obs, reward, terminated, truncated, told = many.step(actions)
    anew = np.flatnonzero(ended)
    assert anew.size
    assert (reward[anew] == 0.0).all() and not (terminated | truncated)[anew].any()
    start = np.asarray(reset(jax.random.key(5)).obs)
    np.testing.assert_allclose(obs[anew[0]], start, atol=1e-6)
    assert (told["distance_m"][anew] == 0.0).all()


@pytest.mark.slow
def test_the_interface_is_playgrounds() -> None:
    bodies = (Planar7(), 6, 20, 10), (Flame(), 7, 31, 10), (Reil(), 2, 29, 5)
    for body, motors, size, substeps in bodies:
        task = MjxEnv(body)
        assert (task.action_size, task.observation_size) == (motors, size)
        assert task.mj_model.nv == task.mjx_model.nv
        assert (task.dt, task.n_substeps) == (pytest.approx(0.01), substeps)
        assert task.sim_dt == body.timestep
        state = jax.eval_shape(task.reset, jax.random.key(0))
        assert state.obs.shape == (size,)
        stepped = jax.eval_shape(task.step, state, jax.ShapeDtypeStruct((motors,), jnp.float32))
        # What training carries through a scan must keep its structure and types.
        assert jax.tree.structure(stepped) == jax.tree.structure(state)
        assert jax.tree.map(lambda leaf: leaf.dtype, stepped) == jax.tree.map(
            lambda leaf: leaf.dtype, state
        )


def test_a_picture_can_be_asked_for() -> None:
    try:
        offscreen.library()
    except RunError as error:
        pytest.skip(str(error))
    env: Any = gymnasium.make("mjxwalk/Planar7-v0", render_mode="rgb_array")
    env.reset(seed=0)
    picture = env.render()
    assert picture.shape == (360, 480, 3) and picture.std() > 10
    env.close()


@pytest.mark.filterwarnings("ignore")
def test_walkers_in_processes_that_were_forked_after_jax_are_refused_in_words(planar: Any) -> None:
    planar.reset(seed=0)  # JAX has threads from here on, which a fork has not
    many: Any = gymnasium.make_vec(
        "mjxwalk/Planar7-v0",
        num_envs=1,
        vectorization_mode="async",
        vector_kwargs={"context": "fork"},
    )
    many.reset_async(seed=0)
    with pytest.raises(RuntimeError, match="forked after JAX .* vector_kwargs={'context': 'spawn'"):
        many.reset_wait(timeout=60)
    many.close(terminate=True)


@pytest.mark.slow
def test_walkers_in_processes_of_their_own_walk(planar: Any) -> None:
    planar.reset(seed=0)
    many: Any = gymnasium.make_vec(
        "mjxwalk/Planar7-v0",
        num_envs=1,
        vectorization_mode="async",
        vector_kwargs={"context": "spawn"},
    )
    obs, _ = many.reset(seed=3)
    np.testing.assert_array_equal(obs[0], planar.reset(seed=3)[0])
    many.close()


def test_wrong_settings_are_refused() -> None:
    with pytest.raises(ValueError, match="body must be a file, .* got 'Cassie'; known are Flame"):
        environments.WalkerEnv(body="Cassie")
    with pytest.raises(ValueError, match="render_mode must be rgb_array or None, got 'human'"):
        environments.WalkerEnv(render_mode="human")
    with pytest.raises(ValueError, match="num_envs and num_terrains must be at least 1"):
        environments.WalkerVectorEnv(num_envs=0)
    with pytest.raises(ValueError, match="ctrl_dt must be at least a step"):
        MjxEnv(ctrl_dt=0.0001)
    with pytest.raises(RuntimeError, match="call reset before step"):
        environments.WalkerEnv().step(np.zeros(6))


def test_gymnasium_finds_the_tasks_by_a_name_with_the_module() -> None:
    for body in mjxwalk.gym.BODIES:
        del gymnasium.registry[f"mjxwalk/{body}-v0"]
    mjxwalk.gym.register()
    assert gymnasium.spec("mjxwalk/Flame-v0").kwargs == {"body": "Flame"}
    env: Any = gymnasium.make("mjxwalk.gym:mjxwalk/Planar7-v0")
    assert env.unwrapped.task.action_size == 6


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (0.5, r"action must have shape \(6,\), got \(\)"),
        (np.zeros(5), r"action must have shape \(6,\), got \(5,\)"),
        (np.zeros((1, 6)), r"action must have shape \(6,\), got \(1, 6\)"),
        ([0.0, 0.0, np.nan, 0.0, 0.0, 0.0], "action must be finite, got nan"),
        (np.full(6, np.inf), "action must be finite, got inf"),
        ("abcdef", "action must hold numbers, got str"),
        (None, r"action must have shape|action must be finite"),
    ],
)
def test_an_action_that_is_not_one_number_for_each_motor_is_refused(
    action: Any, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        environments.as_actions(action, (6,))


def test_both_kinds_of_environments_check_their_actions(monkeypatch: pytest.MonkeyPatch) -> None:
    one, many = environments.WalkerEnv(), environments.WalkerVectorEnv(num_envs=2)
    monkeypatch.setattr(one, "_state", object())
    monkeypatch.setattr(many, "_datas", object())
    with pytest.raises(ValueError, match=r"action must have shape \(6,\), got \(\)"):
        one.step(0.5)
    with pytest.raises(ValueError, match=r"action must have shape \(2, 6\), got \(6,\)"):
        many.step(np.zeros(6))


def test_actions_may_be_lists_and_of_double_precision() -> None:
    for action in ([0.5] * 6, np.full(6, 0.5), np.full(6, 0.5, np.float16)):
        got = environments.as_actions(action, (6,))
        assert got.dtype == jnp.float32
        np.testing.assert_array_equal(got, np.full(6, 0.5))


@pytest.mark.usefixtures("unchecked_types")
def test_a_task_refuses_one_number_for_all_motors() -> None:
    task = MjxEnv(Planar7())
    state = jax.eval_shape(task.reset, jax.random.key(0))
    with pytest.raises(ValueError, match=r"action must have shape \(6,\), got \(\)"):
        jax.eval_shape(task.step, state, 0.5)
