"""Tests of the scripts, each as a user calls it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scripted
import toy
from analysis.walking import recording, walk

from mjxwalk import cli, runs, walkers
from mjxwalk.analysis import trials
from mjxwalk.controllers import LinearReactive, Weights
from mjxwalk.experiments.rayleigh import RAYLEIGH
from mjxwalk.experiments.reil import REIL_UNASSISTED
from mjxwalk.experiments.solomon import PLANAR_FIL
from mjxwalk.walker import Walker

SCRIPTS = Path(__file__).parents[1] / "scripts"


CHAMPION = scripted.load("champion").Champion
PLOT = scripted.load("plot_fitness").PlotFitness
SURVIVAL = scripted.load("link_survival").LinkSurvival
GAIT = scripted.load("gait_table").GaitTable
DENSITY = scripted.load("angle_density").AngleDensity
STICKS = scripted.load("stick_figures").StickFigures
GROUNDS = scripted.load("other_grounds").OtherGrounds
INTEGRATORS = scripted.load("compare_integrators").CompareIntegrators
REIL_TABLE = scripted.load("reil_table").ReilTable
SPATIAL = scripted.load("spatial_table").SpatialTable
OSCILLATORS = scripted.load("ship_oscillators").ShipOscillators
BODY_FILES = scripted.load("body_files").BodyFiles


@pytest.fixture(autouse=True)
def toy_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)
    assert cli.main(["evolve", "--generations", "2", "--out", "a"]) == 0


def test_champion_shows_every_weight_and_writes_them(capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert cli.run("champion.py", CHAMPION, ["a", "--out", "weights.npz"]) == 0
    shown = capsys.readouterr().out.splitlines()
    assert shown[0].startswith("champion of generation")
    gain = runs.load("a").champion["gain"]
    assert shown[1].split() == ["network", "0", "input", "0", f"{gain[0, 0]:.4f}"]
    assert len(shown) == 1 + 6 + 1
    with np.load("weights.npz") as weights:
        np.testing.assert_array_equal(weights["gain"], gain)


def test_champion_of_an_unfinished_run_is_its_fittest(capsys: pytest.CaptureFixture[str]) -> None:
    Path("a/result.json").unlink()
    capsys.readouterr()
    assert cli.run("champion.py", CHAMPION, ["a"]) == 0
    assert "fittest of generation 2" in capsys.readouterr().out


def test_plot_fitness_draws_a_picture() -> None:
    assert cli.run("plot_fitness.py", PLOT, ["a", "--out", "figure.png"]) == 0
    assert Path("figure.png").read_bytes().startswith(b"\x89PNG")


@pytest.fixture
def planar(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets every source hold a planar walker that falls at once, with all links but one."""
    weights = np.ones((6, 16), np.float32)
    weights[0, 1] = 0.0
    genotype: Any = Weights(weights, weights, np.float32(0.5), None)  # type: ignore[arg-type]

    def best(source: str) -> Walker:
        return Walker(
            name=str(source), rank="winner", experiment=PLANAR_FIL, genotype=genotype, generation=1
        )

    monkeypatch.setattr(walkers, "best", best)
    monkeypatch.setattr(walkers, "check", lambda source: None)


@pytest.fixture
def walking(planar: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets its trials be those of a gait with known numbers."""

    def recorded(*args: Any, trials: int, **options: Any) -> Any:
        return recording([walk()] * trials, fell=[False] * trials)

    monkeypatch.setattr(trials, "record_trials", recorded)


@pytest.mark.usefixtures("planar")
def test_link_survival_counts_and_writes_what_evolve_takes(
    capsys: pytest.CaptureFixture[str],
) -> None:
    args = ["b", "c", "--csv", "links.csv", "--figure", "links.png", "--reduced", "links.json"]
    assert cli.run("link_survival.py", SURVIVAL, args) == 0
    out = capsys.readouterr().out
    assert "links left, of 2 runs" in out and "paper_kept" in out
    rows = Path("links.csv").read_text().splitlines()
    assert len(rows) == 1 + 16 and rows[2] == "stance thigh,0,2,2,2,2,2"
    assert Path("links.png").read_bytes().startswith(b"\x89PNG")
    reduced = json.loads(Path("links.json").read_text())
    controller = LinearReactive(links={name: tuple(inputs) for name, inputs in reduced.items()})
    assert int(controller.mask().walking.sum()) == 96 - 1


@pytest.mark.usefixtures("walking")
def test_gait_table_shows_a_known_gait_beside_a_human(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run("gait_table.py", GAIT, ["b", "--trials", "2", "--csv", "gait.csv"]) == 0
    shown = capsys.readouterr().out.splitlines()
    row = next(line for line in shown if line.startswith("b "))
    assert "0.600 ± 0.000" in row and "0.200 ± 0.000" in row and "1.20 ± 0.00" in row
    assert any(line.startswith("human ") and "1.24 ± 0.10" in line for line in shown)
    assert Path("gait.csv").read_text().splitlines()[1].startswith("b,1,2,0,14,")


@pytest.mark.usefixtures("walking")
def test_angle_density_draws_a_picture() -> None:
    assert cli.run("angle_density.py", DENSITY, ["b", "--trials", "2", "--out", "a.png"]) == 0
    assert Path("a.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
@pytest.mark.usefixtures("planar")
def test_walkers_that_fall_are_said_to(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run("gait_table.py", GAIT, ["b", "--trials", "3"]) == 0
    captured = capsys.readouterr()
    assert captured.err == "b: falls in all 3 trials\n"
    assert " -  " in next(line for line in captured.out.splitlines() if line.startswith("b "))
    assert cli.run("angle_density.py", DENSITY, ["b", "--trials", "3"]) == 2
    assert "b takes no whole step in a trial without a fall" in capsys.readouterr().err
    assert cli.run("stick_figures.py", STICKS, ["b", "--start", "9"]) == 2
    assert "the walker's trial is over before 9.0 s" in capsys.readouterr().err
    assert cli.run("stick_figures.py", STICKS, ["b", "--start", "0", "--out", "b.png"]) == 0
    assert Path("b.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("planar")
@pytest.mark.parametrize(
    ("command", "args", "message"),
    [
        (SURVIVAL, [], "no runs were named"),
        (SURVIVAL, ["b", "--threshold", "0"], "--threshold must be above 0 and at most 1, got 0"),
        (
            SURVIVAL,
            ["b", "--csv", "no/such/folder.csv"],
            "no/such/folder.csv is in no folder",
        ),
        (GAIT, [], "no runs were named"),
        (GAIT, ["b", "--trials", "0"], "--trials must be at least 1, got 0"),
        (GAIT, ["b", "--duration", "-1"], "--duration must not be negative, got -1.0"),
        (DENSITY, ["b", "--trials", "-3"], "--trials must be at least 1, got -3"),
        (STICKS, ["b", "--interval", "0"], "--interval must be at least 0.01"),
        (STICKS, ["b", "--start", "inf"], "the walker's trial is over before inf s"),
        (STICKS, ["b", "--terrain-seed", "-1"], "--terrain-seed must be a whole number from 0"),
        (GAIT, ["b", "--duration", "nan"], "--duration must not be negative, got nan"),
        (GAIT, ["b", "--duration", "0.001"], "duration must be a frame at least"),
        (GAIT, ["b", "--seed", "9" * 30], "--seed must be a whole number from 0 to 4294967295"),
        (GROUNDS, ["b", "--trials", "0"], "--trials must be at least 1, got 0"),
        (SPATIAL, ["b"], "b walks in the plane, and this is for walkers in space"),
        (REIL_TABLE, ["zoo:b"], "zoo:b is of another study, whose trials have no distance"),
        (OSCILLATORS, ["b"], "b has no oscillators fitted to a gait"),
    ],
)
def test_wrong_arguments_are_one_sentence(
    command: Any, args: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert cli.run("script.py", command, args) == 2
    complaint = capsys.readouterr().err
    assert message in complaint and complaint.count("\n") == 1


@pytest.mark.parametrize(
    "command", [GAIT, DENSITY, STICKS, GROUNDS, INTEGRATORS, REIL_TABLE, SPATIAL]
)
def test_a_fit_in_which_nothing_walks_is_one_sentence(
    command: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _offer(monkeypatch, RAYLEIGH)
    capsys.readouterr()
    assert cli.run("script.py", command, ["zoo:b"]) == 2
    assert capsys.readouterr().err.startswith("script.py: zoo:b is a fit, in which nothing walks")


def test_a_body_without_angles_by_role_is_one_sentence(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _offer(monkeypatch, REIL_UNASSISTED)
    capsys.readouterr()
    assert cli.run("script.py", DENSITY, ["zoo:b"]) == 2
    assert capsys.readouterr().err.startswith("script.py: zoo:b has no angles by role; see")


@pytest.mark.slow
def test_every_body_has_stick_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    _offer(monkeypatch, REIL_UNASSISTED)
    assert cli.run("script.py", STICKS, ["zoo:b", "--start", "0", "--out", "b.png"]) == 0
    assert Path("b.png").read_bytes().startswith(b"\x89PNG")


def _offer(monkeypatch: pytest.MonkeyPatch, experiment: Any) -> None:
    """Lets every source hold the template of an experiment."""
    walker = Walker(
        name="b",
        rank="winner",
        experiment=experiment,
        genotype=experiment.template(),
        generation=1,
    )
    monkeypatch.setattr(walkers, "best", lambda source: walker)
    monkeypatch.setattr(walkers, "check", lambda source: None)


def test_walkers_without_links_are_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert cli.run("link_survival.py", SURVIVAL, ["a"]) == 2
    assert "a holds walkers without links to count" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("program", "command"),
    [
        ("champion.py", CHAMPION),
        ("plot.py", PLOT),
        ("link_survival.py", SURVIVAL),
        ("gait_table.py", GAIT),
        ("angle_density.py", DENSITY),
        ("stick_figures.py", STICKS),
    ],
)
def test_no_run_is_one_sentence(
    program: str, command: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert cli.run(program, command, ["nowhere"]) == 2
    assert capsys.readouterr().err.startswith(f"{program}: nowhere does not exist")


def test_body_files_tells_what_walks_and_why_not(capsys: pytest.CaptureFixture[str]) -> None:
    folder = Path(__file__).parent / "envs/mjcf/files/cases"
    names = [str(folder / f"{name}.xml") for name in ("rk4", "zero_mass")]
    args = [*names, "--under", str(folder), "--seconds", "0", "--notes"]
    capsys.readouterr()
    assert cli.run("body_files.py", BODY_FILES, args) == 0
    *_, walks, refused = capsys.readouterr().out.splitlines()
    assert walks.startswith("| `rk4.xml` | walks: 2 legs, 6 motors<br>Line 3: the integrator RK4")
    assert refused.startswith("| `zero_mass.xml` | refused: line 6: body wheel moves and has no")
