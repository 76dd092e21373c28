"""Tests of the script that checks a machine with a GPU, on machines that have none."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scripted
from engines.lanes import cpu_threads

from mjxwalk import cli
from mjxwalk.engines import cuda_driver, lanes

SCRIPTED = scripted.load("gpu_check")


def outcomes(distance: Any, work: Any = (4.0, 2.0), fell: Any = (False, True)) -> Any:
    return SimpleNamespace(
        distance=np.float32(distance), work=np.float32(work), fell=np.array(fell, bool)
    )


def test_no_driver_is_one_sentence_and_exit_code_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(cuda_driver, "LIBRARY", "libnowhere.so.1")
    out = tmp_path / "gpu.json"
    assert cli.run("gpu_check.py", SCRIPTED.GpuCheck, ["--out", str(out)]) == 2
    said = capsys.readouterr().err
    assert said.startswith("gpu_check.py: there is no GPU to check: ") and said.count("\n") == 1
    assert not out.exists()


def test_a_driver_without_a_jax_for_it_is_one_sentence(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(cuda_driver, "Device", SimpleNamespace)
    args = ["--out", str(tmp_path / "gpu.json")]
    assert cli.run("gpu_check.py", SCRIPTED.GpuCheck, args) == 2
    said = capsys.readouterr().err
    assert "JAX does not see the GPU" in said and said.count("\n") == 1


@pytest.mark.parametrize(
    ("ours", "agrees"),
    [
        (outcomes([1.0, 2.0]), True),
        (outcomes([1.0, 2.00001]), True),
        (outcomes([1.0, 2.001]), False),
        (outcomes([1.0, np.nan]), False),
        (outcomes([1.0, 2.0], work=[4.1, 2.0]), False),
        (outcomes([1.0, 2.0], fell=[True, True]), False),
    ],
)
def test_outcomes_agree_that_differ_by_rounding(ours: Any, agrees: bool) -> None:
    assert SCRIPTED.difference(ours, outcomes([1.0, 2.0]))["agrees"] is agrees


@pytest.mark.slow
def test_an_engine_that_fails_leaves_the_others_their_turn() -> None:
    def broken(function: Callable[..., Any], in_axes: Any) -> Any:
        raise RuntimeError("no kernel image")

    field = {"broken": broken, "lanes": lanes.vmap}
    latest = time.monotonic() + 1_000
    rows = SCRIPTED.speed("planar7-points", 64, field, latest)["engines"]
    assert rows["broken"]["error"] == "RuntimeError: no kernel image"
    assert rows["lanes"]["steps_per_s"] > 0
    rows = SCRIPTED.speed("planar7-points", 64, field, time.monotonic() - 1)["engines"]
    assert rows["lanes"] == {"left_out": "the time was up"}


@pytest.mark.slow
def test_all_parts_run_where_the_cpu_stands_in(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    field = {"ptx": cpu_threads.vmap, "lanes": lanes.vmap}
    monkeypatch.setattr(SCRIPTED, "gpu", lambda: {"name": "A CPU"})
    monkeypatch.setattr(SCRIPTED, "contenders", lambda: field)
    monkeypatch.setattr(SCRIPTED, "speed", lambda *args: {"walkers": args[1], "engines": {}})
    out = tmp_path / "gpu.json"
    args = ["--out", str(out), "--populations", "8", "16"]
    assert cli.run("gpu_check.py", SCRIPTED.GpuCheck, args) == 0
    found = json.loads(out.read_text(encoding="utf-8"))
    assert found["smoke"]["ptx"]["agrees"] and found["smoke"]["lanes"]["agrees"]
    assert [row["walkers"] for row in found["speed"]] == [8, 16]
