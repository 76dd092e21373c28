"""Tests of what `mjxwalk evolve --body` makes of its arguments; nothing is evolved."""

import dataclasses
import functools
import re
import shlex
from pathlib import Path
from typing import Any

import pytest

from mjxwalk import robots, runs
from mjxwalk.cli import main
from mjxwalk.cli.choosing import choose_run
from mjxwalk.cli.evolve import Evolve
from mjxwalk.cli.parsing import parse
from mjxwalk.cli.sweep import Sweep
from mjxwalk.envs import FitnessTerms, MjcfEnv
from mjxwalk.envs.fitness_terms import COSTS
from mjxwalk.errors import RunError
from mjxwalk.experiments import repeating, run_config

TOY = Path(__file__).parents[1] / "toys/toy_biped.xml"
GAINS = {"distance": 2.0, "alive": 0.5, "clearance": 0.5}
WEIGHTS = {**GAINS, **dict.fromkeys(COSTS, -0.25)}


def chosen(*words: str) -> run_config.Config:
    """Returns the settings that a command would evolve with."""
    asked = parse("mjxwalk evolve", Evolve, words)
    asked.check()
    return choose_run(asked)[0]


@functools.cache
def usual() -> Any:
    """Returns the experiment of the toy as it comes."""
    return chosen("--body", str(TOY)).experiment


@pytest.mark.parametrize("name", robots.names())
def test_every_body_that_ships_makes_a_run_that_reads_back(name: str, tmp_path: Path) -> None:
    made = chosen("--body", name)
    env = made.experiment.env
    assert isinstance(env, MjcfEnv) and len(env.anatomy.legs) == 2
    (tmp_path / "config.json").write_bytes(run_config.text(made))
    assert run_config.read(tmp_path) == made


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("h11", "h1"),
        ("berkeley", "berkeley_humanoid"),
        ("walker", "walker2d"),
        ("planar", "planar7"),
        ("H1", "h1.$"),
    ],
)
def test_a_wrong_name_is_answered_with_the_nearest(name: str, near: str) -> None:
    with pytest.raises(RunError, match=rf"--body {name} does not exist; .* did you mean .*{near}"):
        chosen("--body", name)


def test_a_body_that_ships_is_found_beside_a_folder_of_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("walker2d").mkdir()
    assert chosen("--body", "walker2d").experiment.env.anatomy.root.is_planar


def test_a_contact_law_brings_its_time_step() -> None:
    assert usual().env.contact_law == "points"
    assert chosen("--body", str(TOY), "--contact", "points").experiment == usual()
    env = chosen("--body", str(TOY), "--contact", "mujoco").experiment.env
    assert env.contact_law == "mujoco"
    assert env.timestep == 0.002  # MuJoCo's own, as the toy says none
    with pytest.raises(RunError, match="planar-lpd has one contact law"):
        chosen("planar-lpd", "--contact", "mujoco")


def test_a_contact_law_that_is_set_is_the_one_of_the_flag() -> None:
    words = "--body", str(TOY), "--set", "env.contact_law=mujoco"
    assert chosen(*words) == chosen("--body", str(TOY), "--contact", "mujoco")
    # A time step that is asked for stays, wherever it is written.
    words = "--body", str(TOY), "--set", "env.timestep=0.001", *words[2:]
    env = chosen(*words).experiment.env
    assert (env.contact_law, env.timestep) == ("mujoco", 0.001)


def test_contact_laws_are_named_in_the_help_and_no_other_is_taken(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit):
        main(["evolve", "--help"])
    assert "--contact points|mujoco" in capsys.readouterr().out
    assert main(["evolve", "--body", "h1", "--contact", "soft"]) == 2
    assert "--contact must be points or mujoco, got 'soft'" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["evolve", "sweep"])
def test_a_folder_may_not_be_named_as_a_walker_that_ships(
    command: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["--set", "strategy.sigma=0.1,0.2"] if command == "sweep" else []
    assert main([command, "--out", "./zoo:mine", *words]) == 2
    assert "--out zoo:mine would be taken for a walker that ships" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_sweep_names_a_body_that_ships_as_it_was_named() -> None:
    assert Sweep(body=Path("h1")).anywhere().body == Path("h1")
    assert Sweep(body=Path("robot.xml")).anywhere().body == Path("robot.xml").absolute()


@pytest.mark.parametrize("term", WEIGHTS)
def test_a_terms_weight_is_set_from_the_command_line(term: str) -> None:
    env = chosen("--body", str(TOY), "--set", f"env.terms.{term}={WEIGHTS[term]}").experiment.env
    assert env.terms == dataclasses.replace(usual().env.terms, **{term: WEIGHTS[term]})


def test_every_term_has_a_weight_and_costs_are_never_gains() -> None:
    assert set(FitnessTerms().weights()) == set(WEIGHTS)
    for term, meaning in COSTS.items():
        with pytest.raises(
            RunError, match=f"{term} must be 0 or negative, as it counts {meaning}, got 0.5"
        ):
            chosen("--body", str(TOY), "--set", f"env.terms.{term}=0.5")


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ("env.terms.speeed=1", "did you mean .*speed"),
        ("env.terms.speed=fast", "env.terms.speed"),
        ("env.terms.speed=-1", "env.terms: speed must be 0 or above"),
        ("env.terms.alive=nan", "env.terms.alive must be a number from"),
        ("env.push.direction=up", "must be one of any, forward, sideways, got 'up'"),
        ("env.push.speed=nan", "env.push.speed must be a number from"),
        ('env.forbidden=["head"]', "forbidden names head, and the body has trunk"),
        ("env.forbidden=head", "env.forbidden must be a list such as .*, got 'head'"),
        ("env.acting=angle", "env.acting must be one of target, torque, got 'angle'"),
        ("env.timestep=1", "timestep must be at most 0.0.* s, .* got 1"),
        ("env.contact_law=soft", "env.contact_law must be one of points, mujoco, got 'soft'"),
        ('env.start_angles={"nose": 1}', "no joint nose; it has"),
        (
            'env.start_angles={"knee_left": 9}',
            "knee_left turns from .* to .*, and is to start at 9",
        ),
        ("env.max_pitch=0", "max_pitch must be a number above 0"),
        ("env.min_height=1", "min_height must be below 1, at which trials start, got 1"),
        ("controller.moved=arms", "controller.moved must be one of legs, all, got 'arms'"),
        ("controller.layout.time=2", "controller.layout.time is no setting"),
    ],
)
def test_a_wrong_setting_is_one_sentence(
    words: str, complaint: str, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    run = tmp_path / "run"
    assert main(["evolve", "--body", str(TOY), "--set", words, "--out", str(run)]) == 2
    (told,) = [line for line in capfd.readouterr().err.splitlines() if line.startswith("mjxwalk")]
    assert re.search(complaint, told), told
    assert not run.exists()


@pytest.mark.parametrize(
    "words",
    [
        ("--contact", "mujoco", "--set", "env.solver.iterations=7"),
        ("--set", "env.terms.upright=-2", "--set", "env.push.speed=0.3", "--generations", "4"),
        ("--set", 'env.forbidden=["trunk"]', "--set", "env.course.slope.gradient=0.05"),
    ],
)
def test_a_run_tells_the_command_that_makes_it_again(
    words: tuple[str, ...], tmp_path: Path
) -> None:
    made = chosen("--body", str(TOY), *words)
    (tmp_path / "config.json").write_bytes(run_config.text(made))
    run: Any = runs.Run(
        path=tmp_path,
        config={"seed": 0, "origin": None},
        manifest={},
        metrics={},
        generations=[],
        generation=0,
        damaged={},
        arrays={},
        result=None,
        champion={},
    )
    program, command, *again = shlex.split(repeating.command(run, made.experiment))
    assert (program, command) == ("mjxwalk", "evolve")
    assert chosen(*again).experiment == made.experiment


@pytest.mark.parametrize("name", ["linear", "mlp", "recurrent", "ctrnn", "harmonics"])
def test_a_controller_decides_in_an_experiment_of_any_body(name: str) -> None:
    experiment = chosen("--body", str(TOY), "--controller", name).experiment
    assert experiment.name == f"walk+{name}"
    assert experiment.env.body == chosen("--body", str(TOY)).experiment.env.body


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (("--controller", "mpl"), "unknown controller 'mpl'; did you mean mlp?"),
        (("--controller", "foo"), "'foo'; known are ctrnn, harmonics, linear, mlp, recurrent"),
        (("rayleigh", "--controller", "mlp"), "rayleigh has no controller that could be another"),
        (
            ("solomon-2d", "--controller", "mlp"),
            "is a study; --controller is for one of its phases",
        ),
        (("solomon-2d/fil", "--controller", "mlp"), "goes on with what evolved before"),
    ],
)
def test_a_wrong_controller_is_refused(words: tuple[str, ...], complaint: str, capsys: Any) -> None:
    assert main(["evolve", *words]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert complaint in told and told.count("known are") <= 1


@pytest.mark.parametrize(
    ("words", "setting", "complaint"),
    [
        (("--controller", "mlp"), "controller.hidden=[0]", "from 1 to 4,096 a layer, got [0]"),
        (("--controller", "mlp"), "controller.hidden=8", "must be a list such as [1, 2], got '8'"),
        (("--controller", "mlp"), "controller.limit=0", "limit must be a number above 0, got 0"),
        (("--controller", "mlp"), "controller.period=1e9", "period must be at most"),
        (("--controller", "mlp"), "rewiring.density=2", "density must be above 0 and at most 1"),
        (("--controller", "mlp"), "rewiring=3", "rewiring must be a group of settings, each"),
        (("rayleigh-walk",), "rewiring.every=5", "rewiring must be null, as RayleighWalker has no"),
        (("rayleigh-walk",), "pruning.every=5", "pruning must be null, as RayleighWalker has no"),
        (("gymnasium/Hopper-v5",), "controller.period=0.1", "controller.period is for bodies"),
        (("gymnasium/Hopper-v5",), "controller.moved=all", "all actions move, at every step"),
        (("gymnasium/Hopper-v5",), "env.iterations=0", "iterations must be from 1 to"),
        (
            ("--strategy", "pgpe"),
            "strategy.momentum=0.5",
            "must be null unless optimizer is a name",
        ),
        (("--strategy", "pgpe"), "strategy.optimizer=foo", "known are adam, clipup, sgd"),
    ],
)
def test_a_setting_of_a_controller_that_cannot_be_is_one_sentence(
    words: tuple[str, ...], setting: str, complaint: str, tmp_path: Any, capsys: Any
) -> None:
    args = ["evolve", *words, "--set", setting, "--out", str(tmp_path / "run")]
    assert main(args) == 2
    told = capsys.readouterr().err
    assert complaint in " ".join(told.split()) and told.count("known are") <= 1
    assert not (tmp_path / "run").exists()


def test_settings_that_bound_each_other_are_taken_in_any_order() -> None:
    pair = ("--set", "pruning.reference=2", "--set", "pruning.window=1")
    for words in (pair, (*pair[2:], *pair[:2])):
        pruning = chosen("--body", str(TOY), "--controller", "mlp", *words).experiment.pruning
        assert (pruning.reference, pruning.window) == (2, 1)
