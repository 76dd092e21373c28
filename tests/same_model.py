"""Compares two compiled models, array by array, and as they move."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mjxwalk.envs._mujoco import mujoco

# How each kind of part begins the names of its arrays.
PARTS = "body jnt dof geom site tendon wrap eq pair exclude actuator key qpos".split()
# Arrays that decorate, or say where things lie in memory.
_OTHER = ("_rgba", "_matid", "_user", "adr", "_dataid", "_mpos", "_mquat", "_plugin", "bvhnum")
# Of geoms that touch nothing these are not kept, and a body's margin and kinds follow from them.
_OF_CONTACT = "condim priority friction solmix solref solimp margin gap size".split()


def fields(model: Any) -> dict[str, Any]:
    """Returns the arrays of a model that say how it moves, and where its parts are."""
    found: dict[str, Any] = {}
    touches = np.logical_or(model.geom_contype, model.geom_conaffinity)
    for name in dir(model):
        part, _, rest = name.partition("_")
        if part.rstrip("0") not in PARTS or name.endswith(_OTHER) or name == "body_margin":
            continue
        value = np.asarray(getattr(model, name))
        if value.dtype.kind not in "biuf":
            continue
        found[name] = value[touches] if part == "geom" and rest in _OF_CONTACT else value
    return found


def assert_same(
    one: Any, other: Any, *, ignoring: Sequence[str] = (), close: float = 1e-12
) -> None:
    """Asserts that the models have the same arrays and options."""
    found, others = fields(one), fields(other)
    assert len(found) > 150
    for name in found.keys() - set(ignoring):
        assert found[name].shape == others[name].shape, name
        # Rounding is that of turning by a quaternion and back.
        np.testing.assert_allclose(
            others[name].astype(float), found[name].astype(float), close, close, err_msg=name
        )
    for name in (each for each in dir(one.opt) if not each.startswith("_")):
        np.testing.assert_array_equal(getattr(one.opt, name), getattr(other.opt, name), name)


def assert_moves_alike(one: Any, other: Any, num_steps: int = 100, close: float = 1e-6) -> None:
    """Asserts that the models move alike under the same random controls.

    Args:
      one: a `mujoco.MjModel`, which starts from its first keyframe if it has one.
      other: a model with the same coordinates and controls.
      num_steps: of the models' own timestep.
      close: rounding grows with every contact; 1e-6 is far below what another body would do.
    """
    noise = np.random.default_rng(0)
    datas = [mujoco.MjData(model) for model in (one, other)]
    for model, data in zip((one, other), datas, strict=True):
        if one.nkey:
            mujoco.mj_resetDataKeyframe(model, data, 0)
    for _ in range(num_steps):
        ctrl = noise.uniform(-1.0, 1.0, one.nu)
        for model, data in zip((one, other), datas, strict=True):
            data.ctrl[:] = ctrl
            mujoco.mj_step(model, data)
    assert np.isfinite(datas[0].qpos).all()
    np.testing.assert_allclose(datas[1].qpos, datas[0].qpos, close, close)
    np.testing.assert_allclose(datas[1].qvel, datas[0].qvel, close, 100 * close)
