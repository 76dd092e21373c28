"""Tests of how the measurements go together, with contenders that only count."""

import dataclasses
from types import SimpleNamespace
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from bench.given import RESULTS

from mjxwalk.bench import bodies, child, contenders, measuring
from mjxwalk.bench.c_contenders import Observed
from mjxwalk.bench.measuring import Sizes
from mjxwalk.bench.names import MAIN
from mjxwalk.bench.results import as_json
from mjxwalk.bench.workload import Walked, Workload
from mjxwalk.cli import bench_tables
from mjxwalk.errors import RunError

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
        self.walked = Walked(SimpleNamespace(qpos=np.zeros((size, 3))), jnp.zeros(size, int))
        self.lane_utilisation = 0.9

    def observe(self) -> Observed:
        return Observed(2.5, 1)

    def __call__(self, amount: int) -> int:
        for _ in range(min(amount, 100_000)):
            pass
        return self.size * amount


@pytest.fixture(autouse=True)
def counters(monkeypatch: pytest.MonkeyPatch) -> None:
    """Puts counters in the place of all that computes, and answers for fresh processes."""

    def make(body: Any, size: int, threads: int, *, xla: bool, without: Any) -> dict[str, Counter]:
        mujoco = "mujoco_batch", "mujoco_rollout"
        names = ("lanes", *(["lanes_xla"] if xla else []), "mjx", *mujoco)
        return {name: Counter(size) for name in names if name not in without}

    def engine(vmap: Any, workload: Workload) -> Counter:
        return Counter(len(workload.given.ground.row))

    def evolved(study: Any, generations: int) -> Counter:
        return Counter(8)

    def compiling(body: str, *, file_options: bool) -> child.Compiling:
        return child.Compiling(2.0, 0.1, 1000)

    def memory(body: str, size: int) -> dict[str, int]:
        return {"before": 1000, "after": 1000 + size}

    monkeypatch.setattr(contenders, "make", make)
    monkeypatch.setattr(contenders, "Engine", engine)
    monkeypatch.setattr(measuring, "Evolved", evolved)
    monkeypatch.setattr(child, "compiling", compiling)
    monkeypatch.setattr(child, "peak_memory", memory)


def measured(*names: str, **settings: Any) -> dict[str, Any]:
    """Returns the JSON of a bench."""
    found = measuring.measure(names, dataclasses.replace(TINY, **settings), print)
    bench_tables.show(found)
    return as_json(found)


def test_everything_is_measured_and_fits_the_json(capsys: pytest.CaptureFixture[str]) -> None:
    data = measured(MAIN)
    planar = data["bodies"][MAIN]
    assert set(planar["amounts"]) == {"lanes", "mjx", "mujoco_batch", "mujoco_rollout"}
    assert planar["ratios"].keys() == planar["amounts"].keys() - {"lanes"}
    kernel = planar["kernel"]
    assert (kernel["compile_cold_s"], kernel["compile_warm_s"]) == (2.0, 0.1)
    assert (kernel["operations_per_step"], kernel["width"], kernel["threads"]) == (2000, 8, 2)
    assert kernel["share_of_peak"] > 0
    assert data["evolution"]["lane_utilisation"] == 0.9
    assert data["evolution"]["population"] == 8 and data["evolution"]["generations"] == 3
    assert data["machine"]["usable_cores"] >= 1
    assert data["versions"]["mujoco"]
    shown = capsys.readouterr().out
    assert "mujoco_batch" in shown and "lanes_xla" not in shown


def test_populations_take_the_shortest_steps_at_least() -> None:
    scaling = measured(MAIN)["population_scaling"]
    assert scaling["steps_per_walker"] == {"2": 50_000_000, "4": 50_000_000}
    assert scaling["peak_memory_bytes"] == 1004
    assert all(cost > 0 for cost in scaling["ns_per_step"].values())


def test_what_was_met_is_told_of_bodies_with_contacts() -> None:
    data = measured("planar7", "flame-points")
    touching, points = data["bodies"]["planar7"], data["bodies"]["flame-points"]
    assert (touching["contacts"], touching["warnings"], touching["stopped"]) == (2.5, 1, 0)
    assert (points["contacts"], points["warnings"]) == (None, 0)
    assert data["evolution"] is None and data["population_scaling"] is None


def test_a_quick_bench_leaves_mjx_out_where_it_compiles_slowly_and_says_so(
    capsys: pytest.CaptureFixture[str],
) -> None:
    spatial = measured("flame-points")["bodies"]["flame-points"]
    assert spatial["steps_per_s"]["mjx"] is None and spatial["ratios"]["mjx"] is None
    assert spatial["left_out"] == {"mjx": measuring.TOO_SLOW}
    assert spatial["ratios"]["mujoco_rollout"] > 0
    assert f"mjx left out: {measuring.TOO_SLOW}" in capsys.readouterr().out
    full = measured("flame-points", quick=False)
    assert full["bodies"]["flame-points"]["ratios"]["mjx"] > 0


def test_bodies_of_a_package_that_is_missing_are_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    get: Any = bodies.get

    def missing(name: str, *, file_options: bool = False) -> Any:
        if name == "walker2d":
            raise ValueError("no gymnasium")
        return get(name, file_options=file_options)

    monkeypatch.setattr(bodies, "get", missing)
    data = measured("planar7", "walker2d")
    assert list(data["bodies"]) == ["planar7"] and data["absent"] == {"walker2d": "no gymnasium"}
    assert "walker2d: left out: no gymnasium" in capsys.readouterr().out
    with pytest.raises(RunError, match="no gymnasium"):
        measured("walker2d")


def test_lanes_xla_is_measured_on_request() -> None:
    assert measured(MAIN, xla=True)["bodies"][MAIN]["ratios"]["lanes_xla"] > 0


def test_lanes_xla_is_measured_wherever_there_is_an_accelerator(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    machine = dataclasses.replace(RESULTS.machine, accelerator=True)
    monkeypatch.setattr(measuring, "_machine", lambda: machine)
    assert measured(MAIN)["bodies"][MAIN]["ratios"]["lanes_xla"] > 0
