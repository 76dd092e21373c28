"""Tests of the functions, of learning curves, and of the script that compares them."""

from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
import scripted
import toy

from mjxwalk import cli
from mjxwalk.bench import learning_curves
from mjxwalk.bench.functions import FUNCTIONS, turn
from mjxwalk.bench.learning_curves import LearningCurve

SCRIPT = scripted.load("compare_strategies")


def test_every_function_is_lowest_where_it_is_said_to_be():
    points = jnp.asarray(np.random.default_rng(0).normal(size=(50, 5)), jnp.float32)
    for name, function in FUNCTIONS.items():
        lowest = jnp.ones((1, 5)) if name == "rosenbrock" else jnp.zeros((1, 5))
        at_lowest, elsewhere = function(lowest), function(points)
        assert float(at_lowest[0]) == pytest.approx(0, abs=1e-5)
        assert jnp.all(elsewhere > 1e-3)


def test_functions_have_the_values_worked_out_by_hand():
    point = jnp.array([[2.0, 3.0]])
    values = {name: float(function(point)[0]) for name, function in FUNCTIONS.items()}
    assert values["sphere"] == pytest.approx(13)
    assert values["ellipsoid"] == pytest.approx(4 + 9e6)
    assert values["rosenbrock"] == pytest.approx(100 * (3 - 4) ** 2 + 1)
    assert values["rastrigin"] == pytest.approx(13, rel=1e-4)  # whole numbers are its minima


def test_turning_keeps_lengths_and_mixes_weights():
    point = jnp.array([[1.0, 0.0, 0.0]])
    assert float(jnp.sum(turn(point) ** 2)) == pytest.approx(1, rel=1e-5)
    assert jnp.all(jnp.abs(turn(point)) > 1e-3)


def test_walkers_race_until_their_steps_are_used_up():
    experiment = learning_curves.with_strategy(toy.Toy(), "sep-cma-es")
    assert experiment.strategy.options == {"sigma": 0.3}
    million = 40 * 16 * 2 * toy.GENERATION_STEPS / 1e6  # steps of 40 generations
    evaluator = toy.ToyEvaluator(experiment, "mjx")
    curve = learning_curves.on_walkers(experiment, evaluator, 0, million)
    assert len(curve.effort) == len(curve.reached) == 40
    assert curve.effort[-1] == pytest.approx(million)
    assert curve.reached[-1] > -1 > curve.reached[0]
    again = learning_curves.on_walkers(experiment, evaluator, 0, million)
    assert again == curve


def test_what_was_reached_outlives_a_restart():
    curve = LearningCurve("toy", "snes", 0, list(range(30)), [0.0] * 5 + [4.0] * 10 + [1.0] * 15)
    np.testing.assert_array_equal(SCRIPT.progress(curve)[[0, 14, 29]], [0, 4, 4])


def test_the_script_writes_a_table_and_a_figure_and_keeps_what_is_done(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    script = SCRIPT
    names_run: list[str] = []

    def on_functions(name: str, num_weights: int, seeds: int, evaluations: int) -> Any:
        names_run.append(name)
        for seed in range(seeds):
            yield LearningCurve(f"sphere {num_weights}", name, seed, [evaluations], [seed + 1.0])

    monkeypatch.setattr(learning_curves, "on_functions", on_functions)
    args = ["--out", str(tmp_path / "a"), "--strategies", "snes", "pgpe", "--weights", "4"]
    args += ["--experiments", "--seeds", "3"]
    for _ in range(2):
        assert cli.run("compare_strategies.py", script.CompareStrategies, args) == 0
    assert names_run == ["snes", "pgpe"]
    assert "| sphere 4 | 2 (1.5 to 2.5) | 2 (1.5 to 2.5) |" in capsys.readouterr().out
    assert (tmp_path / "a" / "strategies.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("args", "sentence"),
    [
        (["--strategies", "snse"], "unknown strategy 'snse'; did you mean snes or xnes?"),
        (["--experiments", "planar-ldp"], "unknown experiment 'planar-ldp'; did you mean"),
        (["--seeds", "0"], "--seeds must be above 0, got 0"),
        (["--population", "3"], "--population must be 0 or even, got 3"),
    ],
)
def test_wrong_arguments_of_the_script_are_one_sentence(
    args: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
):
    assert cli.run("compare_strategies.py", SCRIPT.CompareStrategies, args) == 2
    complaint = capsys.readouterr().err
    assert sentence in complaint and complaint.count("\n") == 1
