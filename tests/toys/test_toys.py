"""A body, a controller and a strategy of one's own, without a change of any file of mjxwalk."""

import dataclasses
import shutil
from collections.abc import Iterator
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from toys.toy_controller import ToyController
from toys.toy_strategy import toy_hill_climber

from mjxwalk import cli, experiments, runs, strategies
from mjxwalk.analysis import sticks
from mjxwalk.envs import Action, MjcfEnv, RandomWalk
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.experiments.experiment import Experiment, StrategyChoice
from mjxwalk.gym.mjx_env import MjxEnv
from mjxwalk.runs import files

XML = Path(__file__).with_name("toy_biped.xml").read_text(encoding="utf-8")
TOY = Experiment(
    name="toy-biped",
    env=MjcfEnv(body=XML, terrain=RandomWalk(roughness=0.002), max_time=2.0),
    controller=ToyController(),
    strategy=StrategyChoice(name="toy-search", options={"sigma": 0.3}),
    population_size=16,
    generations=3,
    terrains_per_evaluation=2,
)


@pytest.fixture(scope="module", autouse=True)
def registered() -> Iterator[None]:
    strategies.register("toy-search", toy_hill_climber)
    experiments.register(TOY)
    yield


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("toys") / "run"
    assert cli.main(["evolve", "toy-biped", "--seed", "3", "--out", str(folder)]) == 0
    return folder


def test_evolves_and_its_run_reads_back(run: Path) -> None:
    assert experiments.of_run(runs.load(run)) == TOY
    fitness = runs.load(run).metrics["best_fitness"]
    assert len(fitness) == 3 and np.all(np.isfinite(fitness))


def test_is_watched(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "page.html"
    assert cli.main(["watch", str(run), "--out", str(page)]) == 0
    assert "toy biped" in page.read_text(encoding="utf-8")
    assert "generation" in capsys.readouterr().out


def test_is_verified(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["verify", str(run), "--terrains", "2"]) == 0
    assert "agree" in capsys.readouterr().out


@pytest.mark.parametrize("kind", ["npz", "safetensors", "onnx", "mjcf", "sto", "csv"])
def test_is_exported(run: Path, tmp_path: Path, kind: str) -> None:
    out = tmp_path / f"toy.{kind}"
    assert cli.main(["export", str(run), "--to", kind, "--out", str(out)]) == 0
    assert out.stat().st_size > 0


def test_exported_body_is_the_one_that_evolved(run: Path, tmp_path: Path) -> None:
    out = tmp_path / "toy.xml"
    assert cli.main(["export", str(run), "--to", "mjcf", "--out", str(out)]) == 0
    exported = mujoco.MjModel.from_xml_path(str(out))
    ours = TOY.env.model.mujoco
    np.testing.assert_allclose(exported.body_mass, ours.body_mass)
    # MuJoCo writes six digits.
    np.testing.assert_allclose(exported.jnt_range, ours.jnt_range, rtol=1e-5)


def test_is_filmed(run: Path, tmp_path: Path) -> None:
    film = tmp_path / "toy.gif"
    code = cli.main(["watch", str(run), "--video", str(film), "--seconds", "0.5"])
    if code == 2 and not film.exists():
        pytest.skip("no OpenGL here")
    assert film.read_bytes()[:4] == b"GIF8"


def test_is_reported_and_competes(run: Path) -> None:
    assert cli.main(["tournament", str(run), "--terrains", "8"]) == 0
    assert cli.main(["report", str(run), "--trials", "4"]) == 0


def test_is_a_task_of_reinforcement_learning() -> None:
    task = MjxEnv(TOY.env)
    state = task.step(task.reset(jax.random.key(0)), jnp.zeros(4))
    assert state.obs.shape == (task.observation_size,)
    assert float(state.done) == 0.0


def test_stands_on_its_feet_in_stick_figures() -> None:
    given = TOY.env.level_trials()
    state = TOY.env.reset(given.given(0))
    found = sticks.find(TOY.env, np.asarray(state.qpos)[None], given.given(0).ground)
    assert found.skeletons.shape == (1, 2, 7, 3)  # top, trunk, thigh, shank, heel, toe, shank
    assert abs(found.skeletons[..., 2].min()) < 2e-3  # as deep as its weight presses it


def test_falls_as_in_c_mujoco() -> None:
    """Joints and trunk of a body in the air move as C MuJoCo moves them."""
    env = dataclasses.replace(TOY.env, max_flight_time=10.0, min_height=1e-3)
    given = env.level_trials().given(0)
    state = env.reset(given)
    start = state.qpos.at[2].add(1.0).at[6].set(0.3).at[7].set(0.4).at[4].set(0.2)
    state = state._replace(qpos=start, qvel=state.qvel.at[5].set(0.5).at[3].set(-0.4))
    model = env.model.mujoco
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = np.asarray(start), np.asarray(state.qvel)
    model.opt.timestep = env.timestep
    step = jax.jit(env.step)
    for _ in range(100):
        state = step(state, Action(*[jnp.zeros(4)] * 4), given)
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(state.qpos, data.qpos, atol=2e-3)


def test_is_listed_and_resumed(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stopped = tmp_path / "stopped"
    shutil.copytree(run, stopped)
    for name in ("result.json", "champion.npz", "checkpoints/3"):
        files.remove(stopped, name)
    assert cli.main(["resume", str(stopped)]) == 0
    assert (stopped / "champion.npz").read_bytes() == (run / "champion.npz").read_bytes()
    assert cli.main(["list", "--runs", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert "toy-biped" in shown and "stopped" in shown
