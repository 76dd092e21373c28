"""Every tool on runs of files' bodies, one on two legs and one on four; both hardly evolved."""

import json
import re
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pandas as pd
import pytest
from report.outline import Outline

import mjxwalk.gym
from mjxwalk import runs
from mjxwalk.cli import main
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.errors import RunError
from mjxwalk.pictures import offscreen

BIPED = Path(__file__).parents[1] / "envs/mjcf/files/biped_description/urdf/biped.urdf"
ANT = Path(gymnasium.__file__).parent / "envs/mujoco/assets/ant.xml"
BODIES = {"biped": (BIPED, "urdf_biped", 2, 6), "ant": (ANT, "ant", 4, 8)}
SMALL = ("--generations", "2", "--population", "16", "--set", "env.max_time=1.5", "--seed", "1")
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a folder with a run of each body."""
    path = tmp_path_factory.mktemp("runs")
    for name, (file, *_) in BODIES.items():
        assert main(["evolve", "--body", str(file), *SMALL, "--out", str(path / name)]) == 0
    return path


@pytest.fixture(autouse=True)
def inside(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(made)


@pytest.fixture(params=BODIES)
def run(request: pytest.FixtureRequest) -> str:
    return request.param


def text_of(page: str) -> str:
    return Path(page).read_text(encoding="utf-8")


def test_the_page_shows_the_body(run: str) -> None:
    assert main(["watch", run, "--out", "page.html"]) == 0
    _, name, legs, _ = BODIES[run]
    page = text_of("page.html")
    assert f'"{name}"' in page
    assert "NaN" not in page.partition("<script type=")[0]
    links = runs.load(run).config["experiment"]["env"]["body"].count("<body ")
    assert links > legs


def test_the_film_moves(run: str) -> None:
    try:
        offscreen.library()
    except RunError as error:
        pytest.skip(str(error))
    from PIL import Image, ImageSequence

    assert main(["watch", run, "--video", "film.gif", "--seconds", "0.5"]) == 0
    with Image.open("film.gif") as film:
        pictures = [np.asarray(each.convert("RGB"), int) for each in ImageSequence.Iterator(film)]
    assert len(pictures) > 5
    assert np.abs(pictures[-1] - pictures[0]).max() > 50


def test_the_report_speaks_of_the_body_and_of_no_paper(run: str) -> None:
    assert main(["report", run, "--trials", "4"]) == 0
    folder = Path(run, "report")
    outline = Outline(text_of(f"{run}/report/report.html"))
    _, name, legs, _ = BODIES[run]
    assert not outline.unbalanced
    assert f"walk, {name}, 1 run" in outline.text
    told = re.sub(r"<script.*?</script>", "", text_of(f"{run}/report/report.html"), flags=re.DOTALL)
    assert not re.findall(r"(?i)solomon|paper|figure \d|table \d|adult|human", Outline(told).text)
    assert "the sum of weighted terms" in outline.text
    excused = f"and ant has {legs} legs" in outline.text
    assert (excused, (folder / "gaits.csv").exists()) == (legs == 4, legs == 2)
    assert "fittest" in pd.read_csv(folder / "fitness.csv").columns


def test_gaits_of_two_feet_are_counted() -> None:
    assert main(["report", "biped", "--trials", "4", "--out", "of_two"]) == 0
    (row,) = pd.read_csv("of_two/gaits.csv").to_dict("records")
    assert (row["variant"], row["trials"]) == ("walk", 4)


def test_runs_of_two_bodies_are_not_averaged(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["report", *BODIES, "--out", "both"]) == 2
    assert capfd.readouterr().err == (
        "mjxwalk: biped walks with the body urdf_biped and ant with ant; report on them apart\n"
    )


def test_walkers_compete(run: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["tournament", run, "--terrains", "3"]) == 0
    held = json.loads(text_of(f"{run}/tournament.json"))
    (usual, *_) = held["conditions"]
    assert usual["trials"] == 3 and usual["name"] == "as evolved"
    assert "half the time step" in capfd.readouterr().out


def test_what_is_exported_has_the_bodys_motors(run: str) -> None:
    _, _, _, motors = BODIES[run]
    for kind in ("npz", "mjcf"):
        assert main(["export", run, "--to", kind, "--out", f"{run}.{kind}"]) == 0
    model: Any = mujoco.MjModel.from_xml_path(f"{run}.mjcf")
    contract = json.loads(text_of(f"{run}.json"))
    assert model.nu == motors == len(contract["actions"][0]["order"])


def test_a_trajectory_has_every_coordinate(run: str) -> None:
    args = ("--to", "csv", "--out", f"{run}.csv", "--seconds", "0.3")
    assert main(["export", run, *args]) == 0
    table = pd.read_csv(f"{run}.csv")
    assert len(table) == 31 and np.isfinite(table.to_numpy(float)).all()
    assert table.shape[1] > 6 + BODIES[run][3]


def test_c_mujoco_walks_alike(run: str) -> None:
    assert main(["verify", run, "--terrains", "2"]) == 0


def test_a_run_is_a_task_of_reinforcement_learning(run: str) -> None:
    env: Any = gymnasium.make("mjxwalk/Body-v0", body=run)
    obs, _ = env.reset(seed=0)
    assert env.observation_space.contains(obs)
    assert env.unwrapped.task.env.max_time == 1.5
    assert env.action_space.shape == (BODIES[run][3],)
    assert mjxwalk.gym.MjxEnv(env.unwrapped.task.env).action_size == BODIES[run][3]
