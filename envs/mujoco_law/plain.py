"""Any body of a MJCF file under MuJoCo's own contacts, with the file's joints and motors.

Nothing is derived of legs here: the coordinates are MuJoCo's, and a control is turned into a torque
as the file's motors say.
"""

import functools
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import body_xml
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.derived import roots
from mjxwalk.envs.derived import source as mjcf_source
from mjxwalk.envs.motor import Action
from mjxwalk.envs.mujoco_law import model as mujoco_model
from mjxwalk.envs.mujoco_law import refusals
from mjxwalk.envs.mujoco_law.model import MujocoModel
from mjxwalk.envs.mujoco_law.settings import MujocoContact


class PlainModel(NamedTuple):
    """A body with the file's own joints and motors: constants only.

    Attributes:
      law: the model of a step.
      qpos: where MuJoCo puts the body at first.
      names: of the motors, each its joint's.
      gear: torque of a control of 1, N m.
      lowest: control below which a motor gives no more.
      highest: control above which a motor gives no more.
      first: control that stands for -1 of an action.
      last: control that stands for 1 of an action.
    """

    law: MujocoModel
    qpos: Float[np.ndarray, " nq"]
    names: tuple[str, ...]
    gear: Float[np.ndarray, " motor"]
    lowest: Float[np.ndarray, " motor"]
    highest: Float[np.ndarray, " motor"]
    first: Float[np.ndarray, " motor"]
    last: Float[np.ndarray, " motor"]


@functools.lru_cache(maxsize=16)
def of_text(text: str, law: MujocoContact) -> PlainModel:
    """Returns the model of a body's MJCF with the time step that it says.

    Raises:
      ValueError: it holds what no body may, or what the law or its motors cannot do.
    """
    pose = mjcf_source.start(text)
    found = pose.model
    roots.check(found)
    roots.is_planar(found)  # refuses a root that moves otherwise
    refusals.check(found)
    _check_floor(found)
    motors = [_motor(found, each) for each in range(found.nu)]
    if not motors:
        raise ValueError("the body has no actuators; add <motor joint=.../> for each driven joint")
    dofs, gear, lowest, highest, weakest, strongest = np.array(motors).T
    spec = mujoco.MjSpec.from_string(body_xml.checked(text))
    mujoco_model.set_options(spec, law, float(found.opt.timestep))
    mujoco_model.strip(spec)
    if not law.self_collision:
        mujoco_model.leave_floor_alone_to_touch(spec)
    made = mujoco_model.made(
        spec,
        pose,
        planar=False,  # what is there across the plane cannot be told from what stands still
        turn=np.eye(3),
        feet=(),
        driven=dofs.astype(int),
        lowest=weakest.astype(np.float32),
        highest=strongest.astype(np.float32),
    )
    ranges = np.array(found.actuator_ctrlrange)
    limited = np.isfinite(lowest)
    return PlainModel(
        law=made,
        qpos=np.array(found.qpos0),
        names=tuple(str(found.joint(int(each)).name) for each in found.actuator_trnid[:, 0]),
        gear=gear,
        lowest=lowest,
        highest=highest,
        first=np.where(limited, ranges[:, 0], -1.0),
        last=np.where(limited, ranges[:, 1], 1.0),
    )


def controls(model: PlainModel, values: Float[Array, " motor"]) -> Float[Array, " motor"]:
    """Returns the controls that numbers from -1 to 1 stand for; those beyond stay beyond."""
    middle, half = 0.5 * (model.first + model.last), 0.5 * (model.last - model.first)
    return jnp.asarray(middle + half * values)


def action(model: PlainModel, ctrl: Float[Array, " motor"]) -> Action:
    """Returns the action that gives the torques of controls."""
    torque = jnp.asarray(model.gear) * jnp.clip(ctrl, model.lowest, model.highest)
    nothing = jnp.zeros_like(torque)
    return Action(torque, nothing, nothing, nothing)


def _check_floor(found: Any) -> None:
    floors = mujoco_model.floors(found)
    if not floors:
        raise ValueError('the file has no floor; add a level <geom type="plane"/> at z = 0')
    for floor in floors:
        level = np.allclose(found.geom_quat[floor], [1.0, 0.0, 0.0, 0.0])
        if not level or found.geom_pos[floor][2]:
            name = str(found.geom(floor).name) or f"number {floor}"
            raise ValueError(f"geom {name} is a floor that is not level at z = 0; lay it there")


def _motor(found: Any, actuator: int) -> tuple[float, ...]:
    """Returns a motor's degree of freedom, gear, and limits of its control and its torque."""
    joint = int(found.actuator_trnid[actuator][0])
    plain = (
        int(found.actuator_trntype[actuator]) == int(mujoco.mjtTrn.mjTRN_JOINT)
        and int(found.jnt_type[joint]) in (mjcf_source.HINGE, mjcf_source.SLIDE)
        and int(found.actuator_dyntype[actuator]) == int(mujoco.mjtDyn.mjDYN_NONE)
        and int(found.actuator_gaintype[actuator]) == int(mujoco.mjtGain.mjGAIN_FIXED)
        and int(found.actuator_biastype[actuator]) == int(mujoco.mjtBias.mjBIAS_NONE)
        and not found.jnt_actfrclimited[joint]
    )
    if not plain:
        name = str(found.actuator(actuator).name) or f"number {actuator}"
        raise ValueError(f"actuator {name} is no motor of a joint; write <motor joint=.../>")
    gear = float(found.actuator_gear[actuator][0] * found.actuator_gainprm[actuator][0])
    lowest, highest = -np.inf, np.inf
    if found.actuator_ctrllimited[actuator]:
        lowest, highest = map(float, found.actuator_ctrlrange[actuator])
    weakest, strongest = -np.inf, np.inf
    if found.actuator_forcelimited[actuator]:
        ends = found.actuator_gear[actuator][0] * found.actuator_forcerange[actuator]
        weakest, strongest = float(min(ends)), float(max(ends))
    return float(found.jnt_dofadr[joint]), gear, lowest, highest, weakest, strongest
