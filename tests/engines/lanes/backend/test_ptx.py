"""PTX: its text, and what NVIDIA's assembler says of it where it is installed."""

import functools
import importlib.metadata
import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
from engines.lanes import test_arrays
from engines.lanes.cases import FUNCTIONS, GROUND, X, stroll
from engines.rollouts import BODIES, shapes

from mjxwalk.engines import lanes_ptx
from mjxwalk.engines.lanes.backend import ptx
from mjxwalk.envs import TRIAL_AXES

# Bytes, a fifth above what CUDA 13.0's assembler tells, as another one allots registers otherwise.
SPILLED = {"planar7": 0, "h1, points": 14_500}
CAPABILITIES = ("sm_80", "sm_90", "sm_100")  # of the makers' generations since Ampere


def assembler() -> str | None:
    """Returns where `ptxas` is: on the path, or in a wheel of NVIDIA's."""
    found = shutil.which("ptxas")
    for place in () if found else _in_wheels():
        found = str(place)
    return found


def _in_wheels() -> Iterator[Path]:
    for name in ("nvidia-cuda-nvcc", "nvidia-cuda-nvcc-cu12"):
        try:
            files = importlib.metadata.files(name) or ()
        except importlib.metadata.PackageNotFoundError:
            continue
        yield from (Path(str(file.locate())) for file in files if file.stem == "ptxas")


PTXAS = assembler()
needs_assembler = pytest.mark.skipif(
    PTXAS is None, reason="ptxas is not installed; the wheel nvidia-cuda-nvcc brings it"
)


def assembled(text: str, folder: Path, capability: str) -> dict[str, int]:
    """Returns a kernel's registers, and the bytes that it spills, as the assembler tells."""
    assert PTXAS is not None
    source = folder / "kernel.ptx"
    source.write_text(text)
    command = [PTXAS, "-v", "--gpu-name", capability, str(source), "-o", os.devnull]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    told = done.stdout + done.stderr
    found = {"registers": int(re.findall(r"Used (\d+) registers", told)[0])}
    for what in ("stores", "loads"):
        found[what] = int(re.findall(rf"(\d+) bytes spill {what}", told)[0])
    return found


@functools.cache
def of_rollout(body: str) -> str:
    experiment = BODIES[body]()
    arguments = shapes(experiment, 4)
    return lanes_ptx.lower(experiment.rollout, (0, TRIAL_AXES), *arguments).ptx()


def strolls() -> str:
    args = (np.zeros(4, np.float32), GROUND, np.zeros(4, np.int32), np.int32(300))
    return lanes_ptx.lower(stroll, (0, None, 0, None), *args).ptx()


def test_a_kernel_takes_a_pointer_to_each_array_and_the_count() -> None:
    text = strolls()
    parameters = re.findall(r"\.param (\.u64 \.ptr|\.u64)", text)
    assert parameters == [".u64 .ptr"] * (4 + 3) + [".u64"]
    assert f".visible .entry {ptx.ENTRY}(" in text
    assert f".target {ptx.ARCHITECTURE}" in text
    assert f".maxntid {ptx.THREADS}" in text


def test_subnormals_are_zero_and_roots_and_quotients_are_rounded() -> None:
    text = lanes_ptx.lower(lambda x: jax.numpy.sqrt(x) / (x + 1), 0, X).ptx()
    assert "sqrt.rn.ftz.f32" in text and "div.rn.ftz.f32" in text
    floats = re.findall(r"\t(?:add|sub|mul|fma|sqrt|div)[.\w]*\.f32", text)
    assert floats and all(".ftz" in operation for operation in floats)
    assert ".approx" not in text


def test_the_extreme_of_two_numbers_is_one_instruction_that_passes_nan_on() -> None:
    text = lanes_ptx.lower(lambda x: jax.numpy.maximum(x[0], x[1]), 0, X).ptx()
    assert "max.ftz.NaN.f32" in text and "setp" not in text.split("ld.global", 1)[1]


@pytest.mark.slow
def test_a_step_of_the_planar_body_holds_no_array_and_calls_nothing() -> None:
    text = of_rollout("planar7")
    assert ".local" not in text and "call" not in text


@needs_assembler
@pytest.mark.parametrize("capability", CAPABILITIES)
def test_the_assembler_takes_loops_and_tables(tmp_path: Path, capability: str) -> None:
    found = assembled(strolls(), tmp_path, capability)
    assert found["registers"] < 64 and not found["loads"]


@needs_assembler
def test_the_assembler_takes_loops_over_arrays(tmp_path: Path) -> None:
    text = lanes_ptx.lower(test_arrays.waiting, 0, *test_arrays.drawn()).ptx()
    assert ".local" in text  # where the arrays are
    assert not assembled(text, tmp_path, "sm_90")["loads"]


@needs_assembler
@pytest.mark.slow
@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_assembler_takes_every_function(tmp_path: Path, name: Any) -> None:
    text = lanes_ptx.lower(FUNCTIONS[name], 0, X).ptx()
    assert assembled(text, tmp_path, "sm_90")["registers"] <= 255


@needs_assembler
@pytest.mark.slow
@pytest.mark.parametrize(("body", "most"), SPILLED.items())
def test_a_rollout_spills_no_more_than_it_did(tmp_path: Path, body: str, most: int) -> None:
    found = assembled(of_rollout(body), tmp_path, "sm_90")
    print(f"{body}, sm_90: {found}")  # shown by -s
    assert found["registers"] <= 255 and found["stores"] + found["loads"] <= most
