"""Tests of `mjxwalk verify` of Gymnasium's tasks: who earns what in gymnasium.make."""

import dataclasses
import json
import sys
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

from mjxwalk import cli, experiments, walkers
from mjxwalk.cli.verify import DISAGREES
from mjxwalk.controllers import LinearFeedback
from mjxwalk.envs.gymnasium import TASKS
from mjxwalk.verify import episodes, returns
from mjxwalk.verify.episodes import Episodes
from mjxwalk.walker import Walker

gymnasium: Any = pytest.importorskip("gymnasium")


# A step is traced some times as fast.
pytestmark = pytest.mark.usefixtures("unchecked_types")


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch) -> Walker:
    """Returns what every source is: a walker that has not evolved."""
    experiment = experiments.get("gymnasium/Hopper-v5")
    genotype: Any = jax.tree.map(np.asarray, experiment.template())
    walker = Walker(
        name="hopper", rank="champion", experiment=experiment, genotype=genotype, generation=1
    )
    monkeypatch.setattr(walkers, "check", lambda source, trust: None)
    monkeypatch.setattr(walkers, "best", lambda source: walker)
    return walker


def policies(task: Any, num: int) -> tuple[Any, Any]:
    """Returns linear feedback and so many weights of it, drawn at random."""
    controller: Any = LinearFeedback().on(task)
    leaves, tree = jax.tree.flatten(controller.template())
    rng = np.random.default_rng(0)
    drawn = [rng.normal(0.0, 0.3, (num, *leaf.shape)).astype(np.float32) for leaf in leaves]
    return controller, jax.tree.unflatten(tree, drawn)


@pytest.mark.parametrize("name", ["Hopper-v5", "Humanoid-v5"])
def test_gymnasium_is_played_as_by_a_loop_of_its_own(name: str) -> None:
    task = TASKS[name]()
    controller, genotypes = policies(task, 2)
    played = episodes.in_gymnasium(task, controller, genotypes, [3, 4])
    env = gymnasium.make(name)
    seen, _ = env.reset(seed=4)
    second: Any = jax.tree.map(lambda leaf: leaf[1], genotypes)
    memory, total, steps, over = controller.init(second), 0.0, 0, False
    while not over:
        memory, action = controller.act(second, memory, np.float32(seen))
        # Of these tasks the range of controls lies evenly about zero.
        after = env.step((np.asarray(action) * env.action_space.high).astype(np.float32))
        seen, reward, terminated, truncated, _ = after
        total, steps, over = total + reward, steps + 1, terminated or truncated
    # float32 of one policy is rounded otherwise than of two; falls last some dozen steps.
    assert played.total[1] == pytest.approx(total, rel=1e-3)
    assert (played.steps[1], played.terminated[1]) == (steps, True)


@pytest.mark.slow
def test_a_policy_earns_alike_and_another_task_is_noticed() -> None:
    task, num = TASKS["Hopper-v5"](), 60
    controller, drawn = policies(task, 1)
    same: Any = jax.tree.map(lambda leaf: np.repeat(leaf, num, axis=0), drawn)
    trials = task.sample_trials(jax.random.key(0), num)
    theirs = episodes.in_gymnasium(task, controller, same, returns.seeds(0, num))
    ours = episodes.in_engine(task, controller, same, trials, "lanes")
    assert returns.same_distribution(ours.total, theirs.total) > returns.LEAST_P
    other: Any = dataclasses.replace(task, healthy_reward=0.9)
    ours = episodes.in_engine(other, controller, same, trials, "lanes")
    assert returns.same_distribution(ours.total, theirs.total) < returns.LEAST_P


def test_figures_of_returns_are_counted_by_hand() -> None:
    total, ended = np.array([1.0, 2.0, 3.0, 6.0]), np.array([True, False, False, False])
    found = returns.side("x", Episodes(total, np.array([4, 8, 8, 8]), ended))
    assert (found.mean, found.median, found.lower, found.upper) == (3.0, 2.5, 1.75, 3.75)
    assert found.deviation == pytest.approx(np.sqrt((4 + 1 + 0 + 9) / 4))
    assert (found.terminated_share, found.steps_mean) == (0.25, 7.0)


def test_samples_far_apart_are_not_of_one_distribution() -> None:
    # Of two samples of four without overlap: twice the one of 70 orders that is as far apart.
    far_apart = returns.same_distribution([1, 2, 3, 4], [5, 6, 7, 8])
    assert far_apart == pytest.approx(2 / 70)
    assert returns.same_distribution([1, 2, 3], [1, 2, 3]) == 1.0


@pytest.mark.slow
def test_a_run_earns_in_gymnasium_what_its_engine_says(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, out = str(tmp_path / "run"), tmp_path / "x.json"
    assert cli.main(["evolve", "gymnasium/Hopper-v5", "--generations", "2", "--out", run]) == 0
    args = ["verify", run, "--trials", "20", "--seed", "1", "--json", str(out)]
    assert cli.main(args) == 0
    assert "agrees: if the returns" in capsys.readouterr().out
    told = json.loads(out.read_text())
    assert told["task"] == "Hopper-v5" and told["engine"]["name"] == "lanes"
    # The bonus of being alive, which is not there while walkers evolve, is back.
    for side in (told["engine"], told["reference"]):
        assert len(side["returns"]) == 20 and side["mean"] > 0.9 * side["steps_mean"]


def test_the_command_shows_and_writes_the_figures(
    found: Walker,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def in_engine(task: Any, controller: Any, genotypes: Any, trials: Any, engine: str) -> Episodes:
        assert engine == "lanes"
        played = episodes.in_gymnasium(task, controller, genotypes, range(trials.num))
        return played._replace(total=played.total + bonus)

    bonus = 0.0
    monkeypatch.setattr(episodes, "in_engine", in_engine)
    out = tmp_path / "x.json"
    args = ["verify", "run", "--engine", "lanes", "--trials", "12", "--json", str(out)]
    assert cli.main(args) == 0
    shown = capsys.readouterr().out
    assert "Gymnasium" in shown and "agrees: if the returns" in shown
    told = json.loads(out.read_text())
    assert len(told["engine"]["returns"]) == len(told["reference"]["steps"]) == 12
    assert told["engine"]["returns"] != told["reference"]["returns"]
    bonus = 100.0
    assert cli.main(args) == DISAGREES
    assert "does not agree: if the returns" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("flags", "complaint"),
    [
        (["--contact", "mujoco"], "--contact has no meaning for Gymnasium's Hopper-v5"),
        (["--roughness", "0.01"], "--roughness has no meaning for Gymnasium's Hopper-v5"),
        (["--terrains", "3"], "--terrains has no meaning for Gymnasium's Hopper-v5"),
        (["--trials", "0"], "--trials must be at least 1, got 0"),
    ],
)
def test_flags_of_other_bodies_are_refused(
    found: Walker, flags: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["verify", "run", *flags]) == 2
    told = capsys.readouterr().err
    assert complaint in told and told.count("\n") == 1


def test_trials_of_a_walker_on_terrains_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["verify", "zoo:planar-lpd", "--trials", "3"]) == 2
    assert "walks on terrains, which --terrains counts" in capsys.readouterr().err


def test_without_gymnasium_a_sentence_says_what_to_install(
    found: Walker, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "gymnasium.envs.mujoco.mujoco_env", None)
    assert cli.main(["verify", "run", "--engine", "lanes"]) == 2
    told = capsys.readouterr().err
    assert "playing Hopper-v5 needs gymnasium, which is not installed" in told
    assert told.count("\n") == 1


def test_another_body_than_gymnasiums_is_refused(found: Walker) -> None:
    task = found.experiment.env
    other = dataclasses.replace(task, body=task.body.replace("hopper", "frog"))
    assert other.body != task.body
    experiment = dataclasses.replace(found.experiment, env=other)
    with pytest.raises(ValueError, match="evolved with another body than that of the installed"):
        returns.as_gymnasium_has_it(dataclasses.replace(found, experiment=experiment))
