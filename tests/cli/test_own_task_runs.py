"""Runs of a user's own task: kept with the text, resumed to the same bits, as any other run."""

import hashlib
import json
import shutil
from pathlib import Path

import own_tasks
import pytest
from own_tasks import SMALL, TEXT

from mjxwalk import cli, experiments, runs
from mjxwalk.runs import files


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a folder with a task and a run of it, in which a setting is changed."""
    folder = tmp_path_factory.mktemp("own")
    (folder / "mine.py").write_text(TEXT, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        own_tasks.be("me", folder, patch)
        patch.chdir(folder)
        args = ["evolve", "mine.py", "--set", "env.mass=2", "--seed", "7", "--out", "run"]
        assert cli.main([*args, "--generations", "4", "--population", "8"]) == 0
    return folder


@pytest.fixture(autouse=True)
def _user(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:  # pyright: ignore
    own_tasks.be("me", folder, monkeypatch)
    monkeypatch.chdir(folder)


def test_the_run_keeps_the_text_and_its_digest() -> None:
    assert Path("run/task.py").read_text(encoding="utf-8") == TEXT
    code = json.loads(Path("run/config.json").read_text())["code"]
    sha256 = hashlib.sha256(TEXT.encode()).hexdigest()
    assert code == {"file": "mine.py", "name": "TASK", "sha256": sha256}


def test_settings_of_the_command_line_are_read_back() -> None:
    experiment = experiments.of_run(runs.load("run"))
    assert (experiment.env.mass, experiment.population_size) == (2.0, 8)


def test_a_run_that_was_stopped_ends_with_the_same_bits_whatever_became_of_the_file() -> None:
    shutil.copytree("run", "stopped")
    for name in ("result.json", "champion.npz", "checkpoints/3", "checkpoints/4"):
        files.remove(Path("stopped"), name)
    Path("mine.py").rename("away.py")
    try:
        assert cli.main(["resume", "stopped"]) == 0
    finally:
        Path("away.py").rename("mine.py")
    assert Path("stopped/champion.npz").read_bytes() == Path("run/champion.npz").read_bytes()


def test_a_run_goes_on_from_the_walker_of_an_older_text() -> None:
    newer = TEXT.replace("price: float = 0.001", "price: float = 0.002")
    Path("newer.py").write_text(newer, encoding="utf-8")
    assert cli.main(["evolve", "newer.py", *SMALL, "--from", "run", "--out", "newer"]) == 0
    assert json.loads(Path("newer/config.json").read_text())["origin"]["source"] == "run"


def test_another_controller_decides_and_is_read_back() -> None:
    args = ["evolve", "mine.py", "--controller", "mlp", "--set", "controller.hidden=[3]"]
    assert cli.main([*args, *SMALL, "--out", "mlp"]) == 0
    assert experiments.of_run(runs.load("mlp")).controller.hidden == (3,)
    shutil.copytree("mlp", "mlp-stopped")
    for name in ("result.json", "champion.npz", "checkpoints/2"):
        files.remove(Path("mlp-stopped"), name)
    assert cli.main(["resume", "mlp-stopped"]) == 0
    assert Path("mlp-stopped/champion.npz").read_bytes() == Path("mlp/champion.npz").read_bytes()
    assert cli.main(["report", "mlp", "--trials", "2"]) == 0
    page = Path("mlp/report/report.html").read_text(encoding="utf-8")
    assert "mlp/task.py:TASK --seed 0 --controller mlp" in page


def test_tools_work_or_say_what_they_need(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["tournament", "run", "--terrains", "4"]) == 0
    assert cli.main(["report", "run", "--trials", "2"]) == 0
    page = Path("run/report/report.html").read_text(encoding="utf-8")
    assert "mjxwalk evolve run/task.py:TASK --seed 7" in page and "env.mass=2.0" in page
    capsys.readouterr()
    assert cli.main(["export", "run", "--to", "onnx"]) == 0
    capsys.readouterr()
    for command in (["watch", "run"], ["verify", "run"], ["export", "run", "--to", "sto"]):
        assert cli.main(command) == 2
        told = capsys.readouterr().err
        assert "Hopper" in told and "LeggedEnv" in told and told.count("\n") == 1
    assert cli.main(["watch", "run"]) == 2
    assert "mjxwalk report" in capsys.readouterr().err


def test_an_experiment_that_is_none_of_ours_evolves() -> None:
    text = (Path(__file__).parents[1] / "toys/toy_evolvable.py").read_text(encoding="utf-8")
    Path("point.py").write_text(text, encoding="utf-8")
    assert cli.main(["evolve", "point.py", "--out", "point"]) == 0


@pytest.mark.slow
def test_a_sweep_of_it_evolves_and_goes_on_with_the_text_that_it_began_with(
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("swept.py").write_text(TEXT, encoding="utf-8")
    args = ["sweep", "swept.py", "--seeds", "1", *SMALL, "--set", "env.mass=1,2", "--out", "sweep"]
    assert cli.main(args) == 0
    assert sorted(each.name for each in Path("sweep").glob("mass-*")) == [
        "mass-1-seed-0",
        "mass-2-seed-0",
    ]
    shutil.rmtree("sweep/mass-2-seed-0")
    with Path("swept.py").open("a") as file:
        file.write("# one line more\n")
    capsys.readouterr()
    assert cli.main(["resume", "sweep"]) == 2
    assert "was changed since the sweep began" in capsys.readouterr().err
