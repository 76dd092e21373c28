"""Tests of what is said of a tournament's figures."""

from typing import Any

import pytest

from mjxwalk.analysis.intervals import wilson
from mjxwalk.cli import tournament_table
from mjxwalk.tournament import Condition, Tournament
from mjxwalk.tournament import remarks as remarking
from mjxwalk.tournament.results import AS_EVOLVED, HALF_STEP, PAPERS_STEP, PERTURBED


def condition(name: str, falls: int, **figures: Any) -> Condition:
    interval = wilson(falls, 1000)
    usual: dict[str, Any] = {
        "distance_mean_m": 40.0,
        "cost_of_transport": 0.25,
        "speed_m_s": 1.2,
        "step_length_m": None,
        "double_stance": None,
    }
    return Condition(
        name=name,
        trials=1000,
        distance_sd_m=1.0,
        fall_rate=falls / 1000,
        fall_rate_low=interval.low,
        fall_rate_high=interval.high,
        **(usual | figures),
    )


def held(*conditions: Condition) -> Tournament:
    return Tournament(
        entrants=50,
        newest_generation=80,
        winner_generation=57,
        screening_terrains=20,
        seed=0,
        engine="lanes",
        roughness_m=0.004,
        conditions=conditions,
    )


def test_a_gait_that_holds_at_one_step_only_is_called_an_artefact() -> None:
    remarks = remarking.remarks(held(condition(AS_EVOLVED, 2), condition(HALF_STEP, 480)))
    assert remarks == [
        "the gait is an artefact of its time step: falls 0.2 % (40.0 m) as evolved, "
        "48.0 % (40.0 m) at half the time step"
    ]


def test_both_steps_are_told_in_one_sentence() -> None:
    conditions = (condition(AS_EVOLVED, 2), condition(HALF_STEP, 480), condition(PAPERS_STEP, 900))
    (remark,) = remarking.remarks(held(*conditions))
    assert remark.endswith(
        "48.0 % (40.0 m) at half the time step and 90.0 % (40.0 m) at the paper's explicit step"
    )


def test_a_gait_that_depends_on_its_initial_pose_is_told() -> None:
    conditions = (condition(AS_EVOLVED, 2), condition(HALF_STEP, 3), condition(PERTURBED, 400))
    assert remarking.remarks(held(*conditions)) == [
        "the gait depends on its initial pose: falls 0.2 % (40.0 m) from the usual one, "
        "40.0 % (40.0 m) from perturbed starts",
        "walks alike at half the time step",
    ]


@pytest.mark.parametrize("falls", [0, 20, 500])
def test_falls_that_chance_explains_are_no_difference(falls: int) -> None:
    conditions = (condition(AS_EVOLVED, falls), condition(HALF_STEP, falls + 25))
    assert remarking.remarks(held(*conditions)) == ["walks alike at half the time step"]


def test_a_walker_that_always_falls_has_no_gait_that_could_be_another() -> None:
    conditions = (condition(AS_EVOLVED, 1000), condition(HALF_STEP, 1000, distance_mean_m=60.0))
    assert remarking.remarks(held(*conditions)) == ["falls in every trial, after 40.0 m as evolved"]
    rises = (condition(AS_EVOLVED, 1000), condition(HALF_STEP, 10))
    (remark,) = remarking.remarks(held(*rises))
    assert "artefact of its time step: falls 100.0 % (40.0 m) as evolved, 1.0 %" in remark


def test_who_stops_on_the_way_walks_otherwise_without_a_fall() -> None:
    stops = condition(PERTURBED, 2, distance_mean_m=30.0)
    (remark,) = remarking.remarks(held(condition(AS_EVOLVED, 2), stops))
    assert remark.endswith(
        "falls 0.2 % (40.0 m) from the usual one, 0.2 % (30.0 m) from perturbed starts"
    )


def test_shown_are_all_figures_and_a_dash_where_there_is_none(
    capsys: pytest.CaptureFixture[str],
) -> None:
    full = condition(HALF_STEP, 0, step_length_m=0.6123, double_stance=0.124)
    tournament_table.show(held(condition(AS_EVOLVED, 2, speed_m_s=None), full), "runs/a")
    first, head, usual, half, _ = capsys.readouterr().out.splitlines()
    assert first == (
        "the winner of runs/a is the fittest of generation 57, of 50 on 20 terrains; "
        "roughness 0.004 m"
    )
    assert head.split("  ")[1] == "conditions"
    assert usual.split()[-9:] == ["0.2", "%", "(0.1", "to", "0.7)", "0.250", "-", "-", "-"]
    assert half.split()[-5:] == ["0.250", "1.20", "0.612", "12.4", "%"]


def test_a_walkers_line_has_its_figures_at_half_the_step_too() -> None:
    assert remarking.figures(held(condition(AS_EVOLVED, 2), condition(HALF_STEP, 4))) == (
        "40.0 m, falls 0.2 %, cost of transport 0.25, falls 0.4 % at half the step"
    )
