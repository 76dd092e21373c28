"""Tests of tasks of bodies of files: those that ship, a user's own, and a run's."""

import dataclasses
from pathlib import Path
from typing import Any

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from gymnasium.utils import env_checker

import mjxwalk.gym
from mjxwalk import experiments, robots
from mjxwalk.envs import FitnessTerms, MjcfEnv
from mjxwalk.envs.mjcf import reader
from mjxwalk.errors import RunError
from mjxwalk.experiments import run_config
from mjxwalk.gym import MjxEnv, bodies, environments
from mjxwalk.pictures import offscreen

FILES = Path(__file__).parents[1] / "envs/mjcf/files"
URDF = FILES / "biped_description/urdf/biped.urdf"
ANT = Path(gymnasium.__file__).parent / "envs/mujoco/assets/ant.xml"


@pytest.fixture(scope="module")
def walker2d() -> Any:
    return gymnasium.make("mjxwalk/Walker2d-v0")


def observed(env: Any, data: Any) -> Any:
    """Returns what a policy should see, written out from what the body senses."""
    seen = env.observe(data)
    parts = [seen.up, 0.1 * seen.turning, seen.velocity, seen.heading, seen.angle, 0.1 * seen.rate]
    return np.concatenate([*parts, seen.contact, seen.ankle_x])


def test_every_body_has_a_task_and_those_with_laws_of_their_own_keep_them() -> None:
    tasks = dict(bodies.tasks())
    assert tasks.pop("Body") is None
    assert {name.lower() for name in tasks} == {
        *(name.replace("_", "") for name in robots.names()),
        *(name.lower() for name in mjxwalk.gym.BODIES),
    }
    for title, body in tasks.items():
        assert gymnasium.spec(f"mjxwalk/{title}-v0").kwargs == {"body": body}
    assert (tasks["Flame"], tasks["H1"], tasks["BerkeleyHumanoid"]) == (
        "Flame",
        "h1",
        "berkeley_humanoid",
    )
    with pytest.raises(gymnasium.error.NameNotFound, match="Did you mean: `BerkeleyHumanoid`"):
        gymnasium.make("mjxwalk/BerkelyHumanoid-v0")


def test_gymnasiums_checker_passes(walker2d: Any) -> None:
    env_checker.check_env(walker2d.unwrapped, skip_render_check=True)


@pytest.mark.slow
@pytest.mark.parametrize("title", [name for name, body in bodies.tasks().items() if body])
def test_spaces_are_those_of_every_body(title: str) -> None:
    env: Any = gymnasium.make(f"mjxwalk/{title}-v0")
    task = env.unwrapped.task
    assert env.action_space.shape == (len(task.env.anatomy.motors),)
    state = jax.eval_shape(task.reset, jax.random.key(0))
    stepped = jax.eval_shape(
        task.step, state, jax.ShapeDtypeStruct(env.action_space.shape, jnp.float32)
    )
    assert stepped.obs.shape == env.observation_space.shape
    # What training carries through a scan must keep its structure and types.
    assert jax.tree.map(lambda leaf: (leaf.shape, leaf.dtype), stepped) == jax.tree.map(
        lambda leaf: (leaf.shape, leaf.dtype), state
    )


def test_a_policy_sees_what_the_body_senses_and_gets_what_it_is_worth(walker2d: Any) -> None:
    obs, _ = walker2d.reset(seed=1)
    env, total, terminated = walker2d.unwrapped.task.env, 0.0, False
    told = {"fell": 0.0}
    start = walker2d.unwrapped._state.data
    while not terminated:
        action = walker2d.action_space.sample()
        obs, reward, terminated, truncated, told = walker2d.step(action)
        total += reward
        assert not truncated
    data = walker2d.unwrapped._state.data
    np.testing.assert_allclose(obs, observed(env, data), atol=1e-5)
    assert told["fell"] == 1.0
    assert total == pytest.approx(float(env.fitness(data) - env.fitness(start)), abs=1e-4)
    seconds = float(data.trial.num_steps) * env.timestep
    assert total == pytest.approx(  # by hand, of the terms of a body in the plane
        env.terms.distance * min(told["distance_m"], env.terms.speed * seconds)
        + seconds
        + env.terms.work * float(data.trial.work) / (env.weight * env.stance.height),
        abs=1e-4,
    )


def test_an_action_of_zeros_holds_a_body_where_it_starts(walker2d: Any) -> None:
    walker2d.reset(seed=0)
    start = np.asarray(walker2d.unwrapped._state.data.qpos)[3:]
    for _ in range(5):
        walker2d.step(np.zeros(6, np.float32))
    assert np.asarray(walker2d.unwrapped._state.data.qpos)[3:] == pytest.approx(start, abs=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(("body", "legs", "motors"), [(URDF, 2, 6), (ANT, 4, 8)])
def test_a_file_is_a_task(body: Path, legs: int, motors: int) -> None:
    env: Any = gymnasium.make("mjxwalk/Body-v0", body=body)
    assert env.action_space.shape == (motors,)
    assert len(env.unwrapped.task.env.anatomy.legs) == legs
    env_checker.check_env(env.unwrapped, skip_render_check=True)
    many: Any = gymnasium.make_vec(
        "mjxwalk/Body-v0", num_envs=2, vectorization_mode="vector_entry_point", body=str(body)
    )
    obs, _ = many.reset(seed=0)
    alone, _ = env.reset(seed=0)
    np.testing.assert_allclose(obs[1], alone, atol=1e-5)
    obs = many.step(many.action_space.sample())[0]
    assert many.observation_space.contains(obs) and np.isfinite(obs).all()


def test_what_a_files_reader_leaves_out_is_told() -> None:
    with pytest.warns(UserWarning, match="biped.xml: The mesh .*nowhere/pelvis.stl is missing"):
        bodies.make(FILES / "biped.xml")


def test_a_run_is_a_task_of_its_body_ground_and_rules(tmp_path: Path) -> None:
    usual = experiments.get("walk")
    env = dataclasses.replace(usual.env, terms=FitnessTerms(upright=-2.0), max_time=7.0)
    made = run_config.Config(experiment=dataclasses.replace(usual, env=env))
    (tmp_path / "config.json").write_bytes(run_config.text(made))
    assert bodies.make(tmp_path) == env


def test_a_text_is_a_task() -> None:
    env = MjcfEnv.of(reader.read(FILES / "cases/no_floor.xml").text, acting="torque")
    assert MjxEnv(env).action_size == 6
    assert environments.WalkerEnv(None, env=env).task.env is env


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (None, 'name a body, such as body="robot.xml", an MJCF or URDF file'),
        ("berkeley", "got 'berkeley'; did you mean berkeley_humanoid"),
        ("no.xml", "body must be a file, a run's folder or a name .*, got 'no.xml'; known"),
        (FILES / "cases/no_gravity.xml", "no_gravity.xml: gravity is 0 0 0"),
        (FILES / "cases/muscles.xml", "muscles.xml: line 8: actuator hip is a muscle"),
    ],
)
def test_what_is_no_body_is_refused(body: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        environments.WalkerEnv(body=body)


def test_a_folder_that_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="no run"):
        environments.WalkerEnv(body=tmp_path)


def test_a_picture_of_a_file_of_four_legs_can_be_asked_for() -> None:
    try:
        offscreen.library()
    except RunError as error:
        pytest.skip(str(error))
    env: Any = gymnasium.make("mjxwalk/Body-v0", body=ANT, render_mode="rgb_array")
    env.reset(seed=0)
    picture = env.render()
    assert picture.shape == (360, 480, 3) and picture.std() > 10
    env.close()
