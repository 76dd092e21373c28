"""Tests of `mjxwalk verify`: C MuJoCo agrees with the engines, and tells when they err."""

import json
import re
from pathlib import Path
from typing import Any

import jax
import msgspec
import numpy as np
import pytest
import toy
from verify.stepped import shorter

from mjxwalk import cli, experiments
from mjxwalk.cli.verify import DISAGREES
from mjxwalk.controllers.normalisation import Normalised
from mjxwalk.rollout import Outcome
from mjxwalk.settings import override
from mjxwalk.verify import agreement, comparing, trials
from mjxwalk.verify.agreement import Agreement
from mjxwalk.walker import Walker


@pytest.fixture(scope="module")
def planar() -> Agreement:
    """Returns the first second and a half of the planar walker of the zoo, compared."""
    return comparing.verify(
        shorter("planar-lpd", max_time=1.5), engine="lanes", terrains=3, seed=1, say=print
    )


def check_alike(found: Agreement) -> None:
    # For a second and a half float32 follows float64 step by step; a millimetre is 1e-3 of it.
    np.testing.assert_allclose(found.engine.distance_m, found.reference.distance_m, atol=1e-3)
    cost = found.reference.cost_of_transport
    assert found.engine.cost_of_transport == pytest.approx(cost, rel=5e-3)
    assert found.agrees and found.reference.fell == (False,) * 3
    assert min(found.reference.distance_m) > 0.5


def test_the_planar_walker_walks_alike_in_c_mujoco(planar: Agreement) -> None:
    check_alike(planar)


@pytest.mark.parametrize("acting", ["target", "torque"])
def test_a_policy_moves_our_body_alike_in_c_mujoco(acting: str) -> None:
    experiment = override(experiments.get("planar-lpd+mlp"), "controller.normalise", "true")
    experiment = override(experiment, "env.acting", acting)
    template, draws = experiment.template(), np.random.default_rng(0)
    senses = jax.tree.map(lambda leaf: draws.uniform(0.5, 1.0, leaf.shape), template.senses)
    weights = jax.tree.map(
        lambda leaf: leaf + 0.05 * draws.normal(size=leaf.shape), template.weights
    )
    genotype: Any = jax.tree.map(np.float32, Normalised(weights, senses))
    walker = Walker(
        name="a", rank="champion", experiment=experiment, genotype=genotype, generation=1
    )
    found = comparing.verify(walker, engine="mjx", terrains=3, seed=1, say=print)
    # It falls within a second, in which float32 stays within a millimetre.
    np.testing.assert_allclose(found.engine.distance_m, found.reference.distance_m, atol=1e-3)
    np.testing.assert_allclose(found.engine.duration_s, found.reference.duration_s, atol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["flame-robust", "reil", "reil-assisted"])
def test_walkers_in_space_walk_alike_in_c_mujoco(name: str) -> None:
    walker = shorter(name, max_time=1.5)
    check_alike(comparing.verify(walker, engine="lanes", terrains=3, seed=1, say=print))


def test_a_lighter_body_is_noticed(planar: Agreement) -> None:
    walker = shorter("planar-lpd", max_time=1.5, torso_mass=35.0)
    experiment = walker.experiment
    key = jax.random.fold_in(jax.random.key(1), comparing.VERIFY)
    given = experiment.sample_trials(key, 3)
    outcome = trials.run(experiment.env, experiment.controller, walker.genotype, given)
    lighter = agreement.side("C MuJoCo", outcome, experiment.weight)
    told = {"walker": "a", "generation": 1, "seed": 1, "roughness_m": 0.0}
    assert not agreement.compare(planar.engine, lighter, **told).agrees


def outcome(distance: list[float], fell: list[bool], work: float = 10.0) -> Outcome:
    one: Any = np.ones(len(distance))
    return Outcome(
        fitness=one,
        distance=np.array(distance),  # type: ignore[arg-type]
        duration=one,
        fell=np.array(fell),  # type: ignore[arg-type]
        diverged=one > 1,
        torque_cost=one,
        work=work * one,
        steps=one,
    )


def test_agreement_is_counted_by_hand() -> None:
    usual = agreement.side("lanes", outcome([4.0, 2.0], [False, True]), 2.0)
    other = agreement.side("C MuJoCo", outcome([4.0, 1.0], [False, False], work=8.0), 2.0)
    told = {"walker": "a", "generation": 1, "seed": 0, "roughness_m": 0.0}
    found = agreement.compare(usual, other, **told)
    assert usual.cost_of_transport == pytest.approx(20 / (2 * 6))
    assert found.distance_apart == pytest.approx(0.5 / 2.5)
    assert found.trial_apart == pytest.approx(0.5 / 2.5)
    assert found.cost_apart == pytest.approx(abs(20 / 12 - 16 / 10) / (16 / 10))
    assert (found.other_ends, found.agrees) == (1, False)
    assert agreement.compare(usual, usual, **told).agrees


def test_walkers_that_get_nowhere_have_no_cost() -> None:
    still = agreement.side("x", outcome([-1.0, 0.0], [True, True]), 2.0)
    found = agreement.compare(still, still, walker="a", generation=1, seed=0, roughness_m=0.0)
    assert found.cost_apart is None and found.agrees


def test_the_command_shows_and_writes_the_figures(
    planar: Agreement,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def verify(walker: Any, **asked: Any) -> Agreement:
        assert (asked["terrains"], asked["engine"]) == (3, "lanes")  # that it evolved with
        return planar

    monkeypatch.setattr(comparing, "verify", verify)
    out = tmp_path / "x.json"
    args = ["verify", "zoo:planar-lpd", "--terrains", "3", "--json", str(out)]
    assert cli.main(args) == 0
    shown = capsys.readouterr().out
    assert "agrees: distances" in shown and "0 of 3 trials end otherwise" in shown
    told = json.loads(out.read_text())
    assert told["engine"]["name"] == "lanes" and len(told["reference"]["distance_m"]) == 3
    planar = msgspec.structs.replace(planar, agrees=False)
    assert cli.main(args) == DISAGREES
    assert "does not agree" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("args", "complaint"),
    [
        ([], "RUN|zoo:NAME"),
        (["nowhere"], "nowhere does not exist"),
        (["zoo:nobody"], "there is no 'nobody' in the zoo"),
        (["zoo:planar-lpd", "--terrains", "0"], "--terrains must be at least 1, got 0"),
        (["zoo:planar-lpd", "--seed", "-1"], "--seed must be a whole number from 0 to 4294967295"),
        (["zoo:planar-lpd", "--roughness", "-1"], "--roughness must not be negative, got -1.0"),
        (["zoo:planar-lpd", "--json", "no/x.json"], "--json no/x.json is in no folder"),
        (["toy"], "toy cannot be verified, as its body World is no LeggedEnv"),
    ],
)
def test_wrong_input_is_one_sentence(
    args: list[str],
    complaint: str,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    if args == ["toy"]:
        toy.install(monkeypatch)
        assert cli.main(["evolve", "--generations", "2", "--out", "toy"]) == 0
        capfd.readouterr()
    assert cli.main(["verify", *args]) == 2
    error = capfd.readouterr().err
    assert complaint in error
    assert re.fullmatch(r"mjxwalk: [^\n]+\n", error)
