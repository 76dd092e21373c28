"""Steps under MuJoCo's own contacts, against C MuJoCo's, from the same states."""

import os
import subprocess
import sys
from pathlib import Path

import c_contacts
import jax
import numpy as np
import pytest
from c_contacts import CONVERGED, model_of, stepping, text_of

from mjxwalk.engines import lanes
from mjxwalk.envs.mujoco_law.settings import MujocoContact

# A step is traced some times as fast.
pytestmark = pytest.mark.usefixtures("unchecked_types")
GYMNASIUM = Path(pytest.importorskip("gymnasium").__file__).parent / "envs/mujoco/assets"
EULER = MujocoContact(iterations=100, ls_iterations=20, integrator="euler")
ELLIPTIC = MujocoContact(
    iterations=100, ls_iterations=20, cone="elliptic", integrator="implicitfast"
)


def compare(name: str, law: MujocoContact, share: float = 1.0) -> None:
    """Raises unless float32 steps in lanes agree with C MuJoCo's in float64.

    Velocities change by some 10 m/s^2 times mass over inertia of single joints, a thousand rad/s^2,
    times a time step of some ms; six digits of such a change are 1e-5 rad/s, and a solver that
    starts elsewhere stops 10 of those away.

    Args:
      share: of the states in which they do; the others touch as MJX has it.
    """
    text = text_of(name)
    model = model_of(text, law)
    given = c_contacts.steps(text, model)
    assert (given.contacts > 0).mean() > 0.3
    f32 = jax.tree.map(lambda leaf: leaf.astype(np.float32), (given.before, given.action))
    after = lanes.vmap(stepping(model))(*f32)
    off = np.abs(after.qvel - given.qvel).max(1)
    assert np.mean(off < 5e-4) >= share
    close = off < 5e-4
    np.testing.assert_allclose(after.qpos[close], given.qpos[close], atol=2e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "law", "share"),
    [
        ("h1", CONVERGED, 1.0),
        ("walker2d", CONVERGED, 1.0),
        ("walker2d", ELLIPTIC, 1.0),
        # Boxes against each other, and steep capsules against planes, touch otherwise in MJX.
        ("g1", CONVERGED, 0.95),
        (str(GYMNASIUM / "humanoid.xml"), EULER, 0.99),
        (str(GYMNASIUM / "walker2d_v5.xml"), CONVERGED, 1.0),  # by Runge and Kutta
    ],
)
def test_a_float32_step_agrees_with_c_mujoco(name: str, law: MujocoContact, share: float) -> None:
    compare(name, law, share)


@pytest.mark.parametrize(
    ("name", "law"),
    [
        ("small", CONVERGED),
        ("small, tied", CONVERGED),
        pytest.param("small, tied", ELLIPTIC, marks=pytest.mark.slow),
    ],
)
def test_a_step_of_a_small_body_agrees_with_c_mujoco(name: str, law: MujocoContact) -> None:
    compare(name, law)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "law"), [("tied", CONVERGED), ("tied", ELLIPTIC), ("welded", CONVERGED)]
)
def test_constraints_tendons_and_all_shapes_agree_with_c_mujoco(
    name: str, law: MujocoContact
) -> None:
    compare(name, law)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["h1", "walker2d"])
def test_a_float64_step_agrees_with_c_mujoco_to_its_last_digits(name: str) -> None:
    """What float32 hides shows in float64: every part of the step is MuJoCo's."""
    environment = {
        **os.environ,
        "JAX_ENABLE_X64": "1",
        "PYTHONPATH": str(Path(__file__).parents[1]),
    }
    told = subprocess.run(
        [sys.executable, c_contacts.__file__, name],
        env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert float(told.stdout.split()[-1]) < 1e-8
