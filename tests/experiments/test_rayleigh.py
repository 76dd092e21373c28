"""The fit: its error by hand, both engines, and runs from the command line."""

import dataclasses
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import cli, evaluation, experiments, gaits, runs, walkers
from mjxwalk.analysis import fits
from mjxwalk.envs import Trials
from mjxwalk.experiments.experiment import StrategyChoice
from mjxwalk.experiments.rayleigh import RAYLEIGH, RAYLEIGH_HARMONIC
from mjxwalk.experiments.rayleigh_fit import RayleighFit

SHORT = (
    *("--generations", "6", "--population", "12", "--set", "cycles=2"),
    *("--set", "strategy.breeding_generations=3"),
)
NOWHERE = Trials(np.zeros((1, 1), np.float32)).given(0)
BOTH = pytest.mark.parametrize("fit", [RAYLEIGH, RAYLEIGH_HARMONIC], ids=lambda fit: fit.name)


def _few(fit: RayleighFit) -> RayleighFit:
    return dataclasses.replace(fit, cycles=2, settling_cycles=1)


def _error(fit: RayleighFit, genotype: Any) -> float:
    """Returns the error by its formula, from the motion as a whole."""
    motion = fit.simulate(genotype, fit.settling_cycles + fit.cycles)
    first = fit.settling_cycles * gaits.NUM_POINTS
    timestep = gaits.ADULT_STRIDE_TIME / gaits.NUM_POINTS
    phase = 2 * np.pi * np.arange(fit.cycles * gaits.NUM_POINTS) / gaits.NUM_POINTS
    total = 0.0
    for place in range(4):
        curve = (gaits.adults().hip, gaits.adults().knee)[place // 2]
        series = gaits.harmonics(curve, 10)
        at = phase + np.pi * (place % 2)
        off = gaits.evaluate(series, at) - np.asarray(motion.angle)[first:, place]
        human_rate = 2 * np.pi / gaits.ADULT_STRIDE_TIME * gaits.evaluate(series, at, 1)
        off_rate = human_rate - np.asarray(motion.rate)[first:, place]
        total += fit.proportional * np.mean(np.abs(off))
        total += fit.derivative * np.mean(np.abs(off_rate))
        total += fit.integral * np.mean(np.abs(np.cumsum(off) * timestep))
    return float(total) / 4


@BOTH
def test_fitness_is_minus_the_error_of_the_formula(fit: RayleighFit):
    few = _few(fit)
    outcome = few.rollout(few.template(), NOWHERE)
    # Both sum some hundreds of single-precision terms.
    assert float(outcome.fitness) == pytest.approx(-_error(few, few.template()), rel=1e-4)
    assert int(outcome.steps) == 300


@BOTH
def test_both_engines_give_the_same_error(fit: RayleighFit):
    few = _few(fit)
    strategy = few.make_strategy()
    population = strategy.init(jax.random.key(0), few.template()).breeding.population
    some = jax.tree.map(lambda leaf: np.asarray(leaf)[:16], population)
    lanes, mjx = (
        evaluation.make_evaluator(few, engine).evaluate(some, Trials(jnp.zeros((1, 1))))
        for engine in ("lanes", "mjx")
    )
    # Some of the thesis' networks blow up, and there the last bits decide by how much.
    calm = np.isfinite(mjx.fitness) & (mjx.fitness > -100)
    assert calm.any()
    np.testing.assert_allclose(lanes.fitness[calm], mjx.fitness[calm], rtol=1e-3)
    np.testing.assert_array_equal(lanes.diverged, ~np.isfinite(lanes.fitness))


def test_the_thesis_parameters_are_twelve_degrees_off_at_the_knee():
    fit = fits.measure(_few(RAYLEIGH), RAYLEIGH.template())
    assert 12 < fit.rms[2] < 13
    assert 2 < fit.rms[0] < 3.5


def test_a_fit_of_itself_has_no_error():
    """A gait that is one cycle of a network, given to the network: nothing is left of the error."""
    network = RAYLEIGH_HARMONIC
    genotype = network.template()._replace(
        cosine=jnp.array([[20.0, 0, 0], [0.0, 10, 0]]), centre=jnp.array([10.0, 30.0])
    )
    motion = network.simulate(genotype, 101)
    angle = np.asarray(motion.angle, np.float64)
    cycle, period = fits.last_cycle(angle)
    assert period == pytest.approx(1.0, abs=0.02)
    # From rise to rise of the left hip.
    assert cycle[0, 0] == pytest.approx(cycle[:, 0].mean(), abs=0.5)
    np.testing.assert_allclose(cycle[:50, 0], cycle[50:, 1], atol=0.3)


def test_a_gait_of_the_users_own_is_fitted(tmp_path: Path):
    lines = ["gait_cycle_percent,hip_flexion_deg,knee_flexion_deg"]
    lines += [f"{n},{10 * np.cos(n / 50 * np.pi)},{5 + n % 3}" for n in range(101)]
    (tmp_path / "mine.csv").write_text("\n".join(lines))
    fit = dataclasses.replace(RAYLEIGH, gait=str(tmp_path / "mine.csv"))
    assert fit.target().name == "mine.csv"
    assert np.isfinite(float(_few(fit).rollout(fit.template(), NOWHERE).fitness))


def test_other_strategies_get_the_bounds_that_they_ask_for():
    choice = StrategyChoice(name="pattern-search", options={"initial_mesh": 0.1})
    strategy = dataclasses.replace(RAYLEIGH, strategy=choice).make_strategy()
    state = strategy.init(jax.random.key(0), RAYLEIGH.template())
    population, _ = strategy.ask(jax.random.key(1), state)
    flat = np.concatenate([leaf.reshape(-1) for leaf in jax.tree.leaves(population)])
    assert flat.min() >= 0.0
    unknown = dataclasses.replace(RAYLEIGH, strategy=StrategyChoice(name="simplex"))
    with pytest.raises(ValueError, match="unknown strategy 'simplex'"):
        unknown.make_strategy()


def test_wrong_settings_are_named():
    with pytest.raises(ValueError, match="cycles must be from 1 to .*, got -1"):
        dataclasses.replace(RAYLEIGH, cycles=-1)
    with pytest.raises(ValueError, match="derivative must be 0 or above, got -1.0"):
        dataclasses.replace(RAYLEIGH, derivative=-1.0)


def test_a_fit_runs_from_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "run"
    assert cli.main(["evolve", "rayleigh", *SHORT, "--out", str(out)]) == 0
    said = capsys.readouterr().out
    assert "four Rayleigh oscillators to the gait of Fukuchi" in said
    assert "error best/mean/median" in said
    assert "errors in degrees: left hip" in said
    assert "falls" not in said
    run = runs.load(out)
    assert run.result is not None
    assert set(run.result.champion.figures) == {
        *("left hip", "right hip", "left knee", "right knee"),
        "worst once settled",
    }
    champion = walkers.best(out)
    assert champion.experiment.network == RAYLEIGH.network
    assert cli.main(["tournament", str(out)]) != 0
    assert "is a fit" in capsys.readouterr().err
    # The champion is the fittest that there ever was: one genotype has one fitness.
    again = float(champion.experiment.rollout(champion.genotype, NOWHERE).fitness)
    assert again == pytest.approx(np.nanmax(run.metrics["best_fitness"]), rel=1e-4)


def test_a_fit_that_was_stopped_resumes_to_the_same_bits(tmp_path: Path):
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    few = ["evolve", "rayleigh-harmonic", *SHORT, "--set", "settling_cycles=1"]
    assert cli.main([*few, "--out", str(whole)]) == 0
    assert cli.main([*few, "--out", str(cut), "--save-every", "2"]) == 0
    (cut / "result.json").unlink()
    for name in ("5", "6"):
        for place in (cut / "checkpoints").glob(f"*{name}"):
            for file in sorted(place.rglob("*"), reverse=True):
                file.rmdir() if file.is_dir() else file.unlink()
            place.rmdir()
    assert runs.load(cut).generation == 4
    assert cli.main(["resume", str(cut)]) == 0
    for name, array in runs.load(whole).champion.items():
        assert runs.load(cut).champion[name].tobytes() == array.tobytes()


@pytest.mark.parametrize("name", ["rayleigh", "rayleigh-harmonic", "rayleigh-walk"])
def test_experiments_have_the_names_that_the_command_line_knows(name: str):
    assert experiments.get(name).name == name


@pytest.mark.slow
def test_the_default_fit_gets_as_near_as_a_single_sine_can(tmp_path: Path):
    out = tmp_path / "run"
    assert cli.main(["evolve", "rayleigh", "--out", str(out)]) == 0
    found = runs.load(out).result
    assert found is not None
    assert found.champion.figures["left hip"] < 3.0
    assert found.champion.figures["left knee"] < 12.7


@pytest.mark.slow
def test_harmonics_follow_hip_and_knee_within_two_degrees(tmp_path: Path):
    out = tmp_path / "run"
    assert cli.main(["evolve", "rayleigh-harmonic", "--out", str(out)]) == 0
    found = runs.load(out).result
    assert found is not None
    assert max(found.champion.figures.values()) < 2.0


def test_a_wrong_gait_is_one_sentence_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gait, out = tmp_path / "gait.csv", tmp_path / "run"
    gait.write_text("a,b\n1,2\n")
    assert cli.main(["evolve", "rayleigh", "--set", f"gait={gait}", "--out", str(out)]) == 2
    assert f"{gait}, line 1: the first column must be" in capsys.readouterr().err
    assert not out.exists()
