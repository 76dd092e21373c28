"""Tests of what is derived from timings, of the JSON, and of what is shown."""

import dataclasses

import msgspec
import pytest
from bench.given import RESULTS

from mjxwalk.bench.results import as_json
from mjxwalk.cli import bench_tables


def test_shares_of_peaks_are_those_of_the_given_rates() -> None:
    assert as_json(RESULTS)["evolution"]["share_of_peak"] == 0.9


def test_the_spread_of_costs_is_the_dearest_over_the_cheapest() -> None:
    assert as_json(RESULTS)["population_scaling"]["spread"] == pytest.approx(0.1)


def test_json_has_its_keys_and_survives_a_round_trip() -> None:
    data = as_json(RESULTS)
    assert {"bodies", "evolution", "population_scaling", "machine", "versions"} <= data.keys()
    planar = data["bodies"]["planar7-points"]
    assert planar["ratios"] == {"mjx": 250.0, "mujoco_rollout": 100.0}
    assert planar["kernel"]["share_of_peak"] == 0.4
    assert data["evolution"]["lane_utilisation"] == 0.95
    assert msgspec.json.decode(msgspec.json.encode(data)) == data


def test_what_was_left_out_has_no_numbers() -> None:
    speed = dataclasses.replace(RESULTS.speeds["planar7-points"], left_out={"lanes_xla": "why"})
    data = as_json(dataclasses.replace(RESULTS, speeds={"planar7-points": speed}))
    planar = data["bodies"]["planar7-points"]
    assert planar["steps_per_s"]["lanes_xla"] is None and planar["ratios"]["lanes_xla"] is None


def test_each_body_has_a_row_in_both_tables() -> None:
    points = RESULTS.speeds["planar7-points"]
    touching = dataclasses.replace(points, ratios={"mujoco_batch": 20.0}, contacts=3.5, stopped=1)
    touching = dataclasses.replace(touching, steps_per_s={"lanes": 5e6, "mujoco_batch": 0.25e6})
    both = dataclasses.replace(RESULTS, speeds={"planar7-points": points, "h1": touching})
    speeds, kernels = bench_tables.sections(both)[:2]
    assert speeds.columns == (
        *("body", "lanes", "mjx", "x", "mujoco_rollout", "x", "mujoco_batch", "x"),
    )
    assert speeds.rows[1] == ("h1", "5 M", "-", "-", "-", "-", "250 k", "20")
    assert [row[0] for row in kernels.rows] == ["planar7-points", "h1"]
    assert kernels.rows[0][-3:] == ("-", "0", "0") and kernels.rows[1][-3:] == ("3.5", "1", "0")


def test_plain_lines_tell_the_ratios_and_what_they_are_against(
    capsys: pytest.CaptureFixture[str],
) -> None:
    bench_tables.show(RESULTS)
    shown = capsys.readouterr().out
    assert "1,024 walkers, medians of 3 timings in turn" in shown
    assert "C MuJoCo without contacts and control" in shown
    assert "the rules of a trial are computed but end nobody" in shown
    assert "accelerator" not in shown
    assert "llvmlite" not in shown


def test_an_accelerator_is_named() -> None:
    machine = dataclasses.replace(RESULTS.machine, mjx_devices="1 x H100", accelerator=True)
    shown = bench_tables.sections(dataclasses.replace(RESULTS, machine=machine))[0]
    assert "mjx ran on an accelerator: 1 x H100" in shown.remarks


def test_only_the_main_body_evolves_and_grows() -> None:
    few = dataclasses.replace(RESULTS, evolution=None, population_scaling=None)
    assert len(bench_tables.sections(few)) == 2
    assert as_json(few)["evolution"] is None and as_json(few)["population_scaling"] is None
