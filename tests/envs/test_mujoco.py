"""Tests of the door to MuJoCo: what it warns of and raises."""

import subprocess
import sys
from pathlib import Path

import pytest

from mjxwalk.envs._mujoco import mujoco, refusing

UNSTABLE = """
from mjxwalk.envs._mujoco import mujoco
model = mujoco.MjModel.from_xml_string(
    '<mujoco><worldbody><body><freejoint/><geom size="1"/></body></worldbody></mujoco>'
)
data = mujoco.MjData(model)
for step in range(5):
    data.qvel[:] = float("nan")
    mujoco.mj_step(model, data)
    data.time = 1.0 + step
"""


def test_a_warning_is_told_once_and_writes_no_file(tmp_path: Path) -> None:
    ran = subprocess.run(
        [sys.executable, "-c", UNSTABLE], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert ran.stderr.count("\n") == 1
    assert ran.stderr.startswith("mjxwalk: MuJoCo warns: Nan, Inf or huge value in QVEL")
    assert "Time" not in ran.stderr
    assert not list(tmp_path.iterdir())


COMPILING = """
import warnings
from mjxwalk.envs import _mujoco
class Spec:
    def compile(self):
        # As the binding does, beside what MuJoCo itself says.
        _mujoco._hear("Inertia matrix is too close to singular. Time = 0.0000.")
        warnings.warn("Inertia matrix is too close to singular. Time = 0.0000.", stacklevel=2)
        warnings.warn("A word is old.", stacklevel=2)
for _ in range(3):
    _mujoco.compiled(Spec())
warnings.warn("another's")
"""


def test_a_warning_of_the_compiler_is_told_once() -> None:
    ran = subprocess.run(
        [sys.executable, "-c", COMPILING], capture_output=True, text=True, check=True
    )
    told, by_python, others = ran.stderr.splitlines()
    assert told == "mjxwalk: MuJoCo warns: Inertia matrix is too close to singular."
    assert by_python == "mjxwalk: MuJoCo warns: A word is old."
    assert others.endswith("UserWarning: another's")


@pytest.mark.parametrize(
    "error",
    [
        mujoco.FatalError("engine"),
        RuntimeError("engine"),
        ValueError("engine"),
        NotImplementedError("engine"),
        MemoryError("engine"),
    ],
)
def test_what_mujoco_raises_becomes_one_kind_of_refusal(error: Exception) -> None:
    with pytest.raises(ValueError, match="^MuJoCo cannot compile it: engine$"):
        with refusing("MuJoCo cannot compile it"):
            raise error
