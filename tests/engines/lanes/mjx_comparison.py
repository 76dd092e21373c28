"""A step of MJX's by lanes and by JAX, in float64."""

from typing import Any

import jax
import numpy as np
from engines.lanes.mjx_features import Feature, states
from mujoco import mjx

from mjxwalk.engines import lanes
from mjxwalk.envs._mujoco import mujoco

QUICKLY: dict[str, str | bool] = {"xla_backend_optimization_level": "0"}


def difference(feature: Feature) -> float:
    """Returns how far lanes is from MJX after a step, as a share of the largest number of a kind.

    Raises:
      NotImplementedError: MJX has not got the feature.
      CannotCompileError: lanes has not got it.
    """
    with jax.enable_x64(True):
        built: Any = mujoco.MjModel.from_xml_string(feature.model)
        args, step = states(built, feature.height), stepping(built)
        got = lanes.vmap(step)(*args)
        want = jax.jit(jax.vmap(step)).lower(*args).compile(compiler_options=QUICKLY)(*args)
        return max(map(_difference, got, want))


def stepping(built: Any) -> Any:
    """Returns MJX's step as a function of positions, velocities, activations and controls."""
    ours = mjx.put_model(built, impl="jax")
    rest = mjx.make_data(built, impl="jax")

    def step(qpos: Any, qvel: Any, act: Any, ctrl: Any) -> Any:
        after = mjx.step(ours, rest.replace(qpos=qpos, qvel=qvel, act=act, ctrl=ctrl))
        return after.qpos, after.qvel, after.act, after.qacc, after.sensordata

    return step


def _difference(got: Any, want: Any) -> float:
    want = np.asarray(want)
    assert got.shape == want.shape
    if not got.size:
        return 0.0
    assert np.isfinite(want).all()
    return float(np.abs(got - want).max() / max(np.abs(want).max(), 1e-3))
