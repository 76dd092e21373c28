"""Tests of what makes a phase of a study: ramp, pruning, scale, and the study itself."""

import dataclasses
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
import toy

from mjxwalk import experiments
from mjxwalk.controllers.linear_reactive import INPUTS, NETWORKS, local_links
from mjxwalk.experiments.pruning import Pruning
from mjxwalk.experiments.ramp import RoughnessRamp
from mjxwalk.experiments.scaling import STEEPEST, scaled
from mjxwalk.experiments.solomon import RAMP
from mjxwalk.experiments.study import Study

DOCS = Path(__file__).parents[2] / "docs"
LPD = experiments.get("solomon-2d/lpd")
ROUGH = experiments.get("solomon-2d/rough")
FIL = experiments.get("solomon-2d/fil")
WALK = experiments.get("solomon-2d/walk")


def step(experiment: Any, roughness: float | None = None) -> float:
    """Returns how much higher or lower each node of a terrain is than the one before."""
    heights = experiment.sample_trials(jax.random.key(0), 3, roughness).heights
    return float(np.abs(np.diff(np.asarray(heights, np.float64), axis=1)).max())


def test_a_ramp_goes_on_where_the_fittest_fifth_walk_far_enough() -> None:
    ramp = RoughnessRamp(start=0.01, factor=2.0, distance=5.0)
    far = np.array([0.0] * 8 + [4.0, 6.0])
    assert ramp.after(0.01, far, 0.03) == 0.02
    assert ramp.after(0.02, far, 0.03) == 0.03
    assert ramp.after(0.03, far, 0.03) == 0.03
    assert ramp.after(0.08, far, 0.03) == 0.04
    assert ramp.after(0.04, far, 0.03) == 0.03
    assert ramp.after(0.01, far - 0.1, 0.03) == 0.01
    assert ramp.after(0.01, np.where(far > 5, np.nan, far), 0.03) == 0.01


def test_terrains_are_of_the_environment_s_roughness_or_that_asked_for() -> None:
    # float32 heights of up to a metre
    assert step(FIL) == pytest.approx(0.02, abs=1e-6)
    assert step(FIL, 0.01) == pytest.approx(0.01, abs=1e-6)
    assert FIL.first_roughness() == 0.02
    assert FIL.next_roughness(0.02, np.full(5, 100.0)) == 0.02
    assert ROUGH.first_roughness() == RAMP.start
    assert ROUGH.next_roughness(0.025, np.full(5, 100.0)) == pytest.approx(0.02575)
    assert ROUGH.next_roughness(0.0259, np.full(5, 100.0)) == 0.026


def test_walkers_are_tried_on_the_paper_s_ground_whatever_they_evolved_on() -> None:
    assert (step(LPD), LPD.env.torque_budget) == (pytest.approx(0.026, abs=1e-6), 9_000.0)
    tried = LPD.as_tested()
    assert (step(tried), tried.env.torque_budget) == (pytest.approx(0.02, abs=1e-6), 3_000.0)
    assert tried.as_tested() is tried
    assert FIL.as_tested() is FIL and FIL.env.torque_budget == 1_000.0


def test_generations_of_another_roughness_compile_nothing_anew() -> None:
    LPD.sample_trials(jax.random.key(0), 1, 0.01)
    with jax.no_tracing():
        LPD.sample_trials(jax.random.key(1), 1, 0.02)


@pytest.mark.parametrize(
    "wrong",
    [
        (RoughnessRamp, {"start": -0.1}, "start"),
        (RoughnessRamp, {"start": 0.1, "factor": 1.0}, "factor must be above 1, got 1.0"),
        (RoughnessRamp, {"start": 0.1, "distance": -1.0}, "distance"),
        (Pruning, {"every": 0}, "every"),
        (Pruning, {"floor": 1.5}, "floor must be above 0 and at most 1, got 1.5"),
        (Pruning, {"window": 51}, "window"),
        (Pruning, {"settle": -1}, "settle"),
    ],
)
def test_wrong_settings_are_refused(wrong: tuple[Any, dict[str, Any], str]) -> None:
    kind, settings, complaint = wrong
    with pytest.raises(ValueError, match=complaint):
        kind(**settings)


def test_restarts_and_what_was_evolved_before_exclude_each_other() -> None:
    with pytest.raises(ValueError, match="restart_after must be null"):
        dataclasses.replace(WALK, start="population")
    with pytest.raises(ValueError, match="restart_after must be null"):
        dataclasses.replace(WALK, pruning=Pruning())


def test_scaling_keeps_the_structure() -> None:
    sil = scaled(experiments.get("solomon-2d/sil"), 0.02)
    assert (sil.population_size, sil.generations) == (10, 60)
    assert sil.pruning == Pruning(every=1, reference=1, window=1, settle=4)
    assert scaled(ROUGH, 0.5) == dataclasses.replace(
        ROUGH,
        population_size=160,
        generations=100,
        ramp=dataclasses.replace(RAMP, factor=RAMP.factor**2),
    )
    tiny = scaled(dataclasses.replace(WALK, generations=500), 1e-3)
    assert (tiny.population_size, tiny.generations, tiny.restart_after) == (10, 2, 2)
    lpd = scaled(experiments.get("planar-lpd"), 1e-9)
    assert (lpd.restart_after, lpd.restart_at) == (2, 3)
    assert scaled(LPD, 1.0) == LPD
    assert scaled(ROUGH, 1e-9).ramp == dataclasses.replace(RAMP, factor=STEEPEST)
    # What is smaller than a floor already is not raised to it.
    assert scaled(toy.Toy(population_size=4), 0.5).population_size == 4
    with pytest.raises(ValueError, match="scale must be above 0 and at most 10000, got -1.0"):
        scaled(LPD, -1.0)


def test_phases_are_chained_and_named_after_their_study() -> None:
    study = experiments.get_study("solomon-2d")
    assert [e.start for _, e in study.phases] == [
        "zero",
        "winner",
        "mean",
        "mean",
        "winner",
        "population",
    ]
    assert study.phase("fil") is experiments.get("solomon-2d/fil")
    assert [e.population_size for _, e in study.scaled(0.2).phases] == [128, 64, 30, 30, 30, 30]
    with pytest.raises(ValueError, match="must be named other/lpd, got solomon-2d/lpd"):
        Study(name="other", phases=(("lpd", LPD),))
    with pytest.raises(ValueError, match="solomon-2d/rough comes first and must start from zero"):
        Study(name="solomon-2d", phases=study.phases[1:])
    with pytest.raises(ValueError, match="phases must have names of their own"):
        Study(name="solomon-2d", phases=study.phases[:1] * 2)


def test_names_and_phases_are_those_of_the_studies_themselves() -> None:
    for name in experiments.studies():
        study = experiments.get_study(name)
        assert study.name == name
        assert [phase for phase, _ in study.phases] == experiments.phases(name)
    for name in experiments.names():
        assert experiments.get(name).name == name
    with pytest.raises(ValueError, match="did you mean solomon-2d/fil"):
        experiments.get("solomon-2d/fill")
    with pytest.raises(ValueError, match="did you mean solomon-2d"):
        experiments.get_study("solomon2d")


def test_the_paper_s_numbers_are_those_of_the_study() -> None:
    lpd, fil, sil = (phase for _, phase in experiments.get_study("solomon-2d-literal").phases)
    assert {e.population_size for e in (lpd, fil, sil)} == {150}
    assert {e.terrains_per_evaluation for e in (lpd, fil, sil)} == {1}
    for phase in (lpd, fil, sil):
        assert step(phase) == pytest.approx(0.02, abs=1e-6)
    assert (lpd.generations, fil.generations) == (500, 3000)
    assert lpd.env.torque_budget == 3 * fil.env.torque_budget
    assert lpd.strategy.options["sigma"] == 0.05
    assert fil.strategy.options == {"sigma": 0.005, "initial_sigma": 0.05}
    assert sil.pruning == Pruning(every=10, floor=0.9, reference=50, window=10, settle=200)


def test_rsil_has_the_local_links_and_those_that_the_docs_found_left() -> None:
    controller = experiments.get("solomon-2d-rsil/rsil").controller
    mask: Any = controller.mask()
    links = np.asarray(mask.walking)
    assert links.shape == (len(NETWORKS), len(INPUTS)) and (links | ~local_links()).all()
    found = (DOCS / "solomon-2d.md").read_text().split("### The reduced set")[1].split("###")[0]
    for network, kept in zip(NETWORKS, links & ~local_links(), strict=True):
        names = [name for name, there in zip(INPUTS, kept, strict=True) if there]
        assert (f"| {network} | {', '.join(names)} |" in found) is bool(names)


def test_a_pruned_population_keeps_what_is_not_to_be_pruned() -> None:
    experiment = scaled(experiments.get("solomon-2d/sil"), 0.05)
    strategy = experiment.make_strategy()
    state = strategy.init(jax.random.key(0), experiment.template())
    state = strategy.begin(state.inner, np.ones(50, np.float32))  # type: ignore[attr-defined]
    _, state = strategy.ask(jax.random.key(1), state)
    masks = state.inner.mask
    # All but the elite lose one of 78 links, from both sets of weights.
    assert masks.walking.sum(axis=(1, 2)).tolist() == [96, *[95] * 9]
    np.testing.assert_array_equal(masks.initiation, masks.walking)
    assert np.all(np.asarray(masks.walking)[:, local_links()]) and np.all(masks.blend_time)
