"""A walker with MuJoCo's own contacts: MJX with its constraint solver in the kernel."""

from typing import Any

import jax
import numpy as np
import pytest
from engines.lanes.walker2d import model
from mujoco import mjx

from mjxwalk.engines import lanes
from mjxwalk.envs._mujoco import mujoco

NUM_STATES = 64


def stepping(built: Any) -> Any:
    """Returns MJX's step as a function of positions, velocities and controls."""
    ours, rest = mjx.put_model(built), mjx.make_data(built)

    def step(qpos: Any, qvel: Any, ctrl: Any) -> Any:
        after = mjx.step(ours, rest.replace(qpos=qpos, qvel=qvel, ctrl=ctrl))
        return after.qpos, after.qvel

    return step


def states() -> tuple[Any, Any, Any]:
    """Returns postures near the ground, most with a foot in it."""
    rng = np.random.default_rng(0)
    qpos = rng.uniform(-0.3, 0.3, (NUM_STATES, 9))
    qpos[:, 0], qpos[:, 1] = 0.0, rng.uniform(-0.12, 0.02, NUM_STATES)
    qpos[:, 3:] -= 0.1
    qvel, ctrl = rng.normal(size=(NUM_STATES, 9)), rng.uniform(-1, 1, (NUM_STATES, 6))
    return qpos.astype(np.float32), qvel.astype(np.float32), ctrl.astype(np.float32)


@pytest.mark.slow
def test_a_step_in_contact_agrees_with_c_mujoco_where_the_solver_converges() -> None:
    """Newton's method and its line search loop here.

    In float32 they stop 6e-4 of the largest speed away in one of these states, with JAX's own
    compiler as with ours, and 6e-5 in the others.
    """
    built, args = model(iterations=20, ls_iterations=20), states()
    qpos, qvel = lanes.vmap(stepping(built))(*args)
    touching = 0
    for number, (position, velocity, control) in enumerate(zip(*args, strict=True)):
        data = mujoco.MjData(built)
        data.qpos[:], data.qvel[:], data.ctrl[:] = position, velocity, control
        mujoco.mj_step(built, data)
        touching += data.ncon > 0
        np.testing.assert_allclose(qpos[number], data.qpos, atol=1.5e-5)
        np.testing.assert_allclose(qvel[number], data.qvel, atol=1e-3 * np.abs(qvel).max())
    assert touching > NUM_STATES / 2


@pytest.mark.slow
def test_a_step_with_a_single_iteration_agrees_with_jax() -> None:
    """A step of Newton's that has not converged is steep in its input: 1e-4 of 20 rad/s."""
    step, args = stepping(model(iterations=1, ls_iterations=4)), states()
    got, want = lanes.vmap(step)(*args), jax.jit(jax.vmap(step))(*args)
    np.testing.assert_allclose(got[0], want[0], atol=5e-6)
    np.testing.assert_allclose(got[1], want[1], atol=1e-4 * np.abs(want[1]).max())
