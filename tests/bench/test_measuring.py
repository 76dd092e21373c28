"""Tests of how the measurements go together, with contenders that only count."""

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest
from bench.given import RESULTS

from mjxwalk.bench import bodies, child, contenders, measuring
from mjxwalk.bench.measuring import Sizes
from mjxwalk.bench.results import as_json
from mjxwalk.cli import bench_tables

TINY = Sizes(
    quick=True,
    population=4,
    seconds=1e-4,
    repeats=2,
    generations=3,
    populations=(2, 4),
    shortest=50_000_000,
)


class Counter:
    """A contender that takes no time to speak of."""

    def __init__(self, size: int) -> None:
        self.size = size
        target = SimpleNamespace(width=8)
        kernel = SimpleNamespace(operations=2000, target=target)
        self.mapped = SimpleNamespace(compiled=kernel, threads=2)
        self.lane_utilisation = 0.9

    def __call__(self, amount: int) -> int:
        for _ in range(min(amount, 100_000)):
            pass
        return self.size * amount


@pytest.fixture(autouse=True)
def counters(monkeypatch: pytest.MonkeyPatch) -> None:
    """Puts counters in the place of all that computes, and answers for fresh processes."""

    def make(body: Any, size: int, threads: int, *, xla: bool, without: Any) -> dict[str, Counter]:
        names = ("lanes", *(["lanes_xla"] if xla else []), "mjx", "mujoco_rollout")
        return {name: Counter(size) for name in names if name not in without}

    def engine(vmap: Any, workload: bodies.Workload) -> Counter:
        return Counter(len(workload.given.ground.row))

    def evolved(study: Any, generations: int) -> Counter:
        return Counter(8)

    def seconds(body: str) -> tuple[float, float]:
        return 2.0, 0.1

    def memory(body: str, size: int) -> dict[str, int]:
        return {"before": 1000, "after": 1000 + size}

    monkeypatch.setattr(contenders, "make", make)
    monkeypatch.setattr(contenders, "Engine", engine)
    monkeypatch.setattr(measuring, "Evolved", evolved)
    monkeypatch.setattr(child, "compile_seconds", seconds)
    monkeypatch.setattr(child, "peak_memory", memory)


def test_everything_is_measured_and_fits_the_json() -> None:
    said: list[str] = []
    data = as_json(measuring.measure(TINY, said.append))
    assert len(said) == 6
    planar = data["planar"]
    assert set(planar["steps_per_walker"]) == {"lanes", "mjx", "mujoco_rollout"}
    assert planar["lanes_over_mjx"] == planar["lanes"] / planar["mjx"]
    assert data["compile_s"] == {"cold": 2.0, "warm": 0.1}
    assert data["lane_utilisation"] == 0.9
    assert data["evolution"]["population"] == 8 and data["evolution"]["generations"] == 3
    arithmetic = data["arithmetic"]
    assert (arithmetic["operations_per_step"], arithmetic["width"]) == (2000, 8)
    assert arithmetic["gflops"] == pytest.approx(2000 * planar["lanes"] / 1e9)
    assert arithmetic["peak_gflops"] > 0
    assert data["machine"]["usable_cores"] >= 1
    assert data["versions"]["mujoco"]


def test_populations_take_the_shortest_steps_at_least() -> None:
    scaling = as_json(measuring.measure(TINY, print))["population_scaling"]
    assert scaling["steps_per_walker"] == {"2": 50_000_000, "4": 50_000_000}
    assert scaling["peak_memory_bytes"] == 1004
    assert all(cost > 0 for cost in scaling["ns_per_step"].values())


def test_a_quick_bench_leaves_mjx_out_where_it_compiles_slowly_and_says_so(
    capsys: pytest.CaptureFixture[str],
) -> None:
    quick = measuring.measure(TINY, print)
    spatial = as_json(quick)["spatial"]
    assert spatial["mjx"] is None and spatial["lanes_over_mjx"] is None
    assert spatial["left_out"] == {"mjx": measuring.TOO_SLOW}
    assert spatial["lanes_over_mujoco_rollout"] > 0
    bench_tables.show(quick)
    assert f"mjx left out: {measuring.TOO_SLOW}" in capsys.readouterr().out
    full = measuring.measure(dataclasses.replace(TINY, quick=False), print)
    assert as_json(full)["spatial"]["lanes_over_mjx"] > 0


def test_what_is_measured_can_be_shown(capsys: pytest.CaptureFixture[str]) -> None:
    bench_tables.show(measuring.measure(TINY, print))
    shown = capsys.readouterr().out
    assert "lanes / mujoco_rollout = " in shown and "lanes_xla" not in shown


def test_lanes_xla_is_measured_on_request(capsys: pytest.CaptureFixture[str]) -> None:
    measured = measuring.measure(dataclasses.replace(TINY, xla=True), print)
    planar = as_json(measured)["planar"]
    assert planar["lanes_over_lanes_xla"] == planar["lanes"] / planar["lanes_xla"]
    bench_tables.show(measured)
    assert "lanes_xla / mjx = " in capsys.readouterr().out


def test_lanes_xla_is_measured_wherever_there_is_an_accelerator(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    machine = dataclasses.replace(RESULTS.machine, accelerator=True)
    monkeypatch.setattr(measuring, "_machine", lambda: machine)
    assert measuring.measure(TINY, print).speeds["planar"].steps_per_s["lanes_xla"] > 0
