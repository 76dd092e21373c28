"""Tests of what is derived from timings, of the JSON, and of what is shown."""

import dataclasses

import msgspec
import pytest
from bench.given import RESULTS

from mjxwalk.bench.results import as_json
from mjxwalk.cli import bench_tables


def test_ratios_are_those_of_the_given_steps() -> None:
    planar = as_json(RESULTS)["planar"]
    assert planar["lanes_over_mjx"] == 250.0
    assert planar["lanes_over_mujoco_rollout"] == 100.0


def test_shares_of_peaks_are_those_of_the_given_rates() -> None:
    data = as_json(RESULTS)
    assert data["evolution"]["share_of_peak"] == 0.9
    # 2,000 operations x 50 M steps/s are 100 GFLOP/s of 250.
    assert data["arithmetic"]["gflops"] == pytest.approx(100.0)
    assert data["arithmetic"]["share_of_peak"] == pytest.approx(0.4)


def test_the_spread_of_costs_is_the_dearest_over_the_cheapest() -> None:
    assert as_json(RESULTS)["population_scaling"]["spread"] == pytest.approx(0.1)


def test_json_has_its_keys_and_survives_a_round_trip() -> None:
    data = as_json(RESULTS)
    expected = {"planar", "compile_s", "lane_utilisation", "population_scaling", "machine"}
    assert expected | {"versions", "arithmetic", "evolution"} <= data.keys()
    assert data["compile_s"] == {"cold": 2.5, "warm": 0.05}
    assert data["lane_utilisation"] == 0.95
    assert msgspec.json.decode(msgspec.json.encode(data)) == data


def test_a_second_body_has_a_key_and_a_table_of_its_own() -> None:
    planar = RESULTS.speeds["planar"]
    both = dataclasses.replace(RESULTS, speeds={"planar": planar, "spatial": planar})
    assert as_json(both)["spatial"] == as_json(both)["planar"]
    assert len(bench_tables.sections(both)) == len(bench_tables.sections(RESULTS)) + 1


def test_plain_lines_tell_the_ratios_and_what_they_are_against(
    capsys: pytest.CaptureFixture[str],
) -> None:
    bench_tables.show(RESULTS)
    shown = capsys.readouterr().out
    assert "lanes / mjx = 250" in shown
    assert "lanes / mujoco_rollout = 100" in shown
    assert "planar body, 1,024 walkers" in shown
    assert "same work" in shown
    assert "accelerator" not in shown
    assert "llvmlite" not in shown


def test_an_accelerator_is_named() -> None:
    machine = dataclasses.replace(RESULTS.machine, mjx_devices="1 x H100", accelerator=True)
    shown = bench_tables.sections(dataclasses.replace(RESULTS, machine=machine))[0]
    assert "mjx ran on an accelerator: 1 x H100" in shown.remarks
    assert shown.rows[1][:2] == ("mjx", "1 x H100")
