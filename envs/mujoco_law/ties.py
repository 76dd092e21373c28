"""What MJX leaves out of `<connect>` and `<weld>`: that the points they hold together turn.

C MuJoCo takes J' v from the acceleration that a row aims at, J being its Jacobian, v the velocity
and J' v what the points would gain of relative velocity if no joint accelerated. MJX does not. Of
a weld's turning rows it is as small as its error, and left out here too.
"""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import dynamics
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mujoco_law.model import MujocoModel

_SITE = int(mujoco.mjtObj.mjOBJ_SITE)
# Kinds in the order of MJX's rows, the rows of one, and where eq_data has the two anchors.
_KINDS = (
    (int(mujoco.mjtEq.mjEQ_CONNECT), 3, (0, 3)),
    (int(mujoco.mjtEq.mjEQ_WELD), 6, (3, 0)),
)


def turning(model: MujocoModel, data: Any) -> Float[Array, " row"]:
    """Returns J' v of the first rows that MJX has found, those of `<connect>` and `<weld>`."""
    found = model.mujoco
    parts: list[Array] = [jnp.zeros(0)]
    if int(found.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_EQUALITY):
        return parts[0]
    for kind, rows, anchors in _KINDS:
        for tie in np.flatnonzero(found.eq_type == kind):
            gained = [_gained(model, data, int(tie), end, anchors[end]) for end in (0, 1)]
            active = float(found.eq_active0[tie])
            parts += [active * (gained[0] - gained[1]), jnp.zeros(rows - 3)]
    return jnp.concatenate(parts)


def _gained(model: MujocoModel, data: Any, tie: int, end: int, anchor: int) -> Float[Array, "3"]:
    """Returns the acceleration of one end of a tie if no joint accelerated, m/s^2."""
    found = model.mujoco
    number = int((found.eq_obj1id, found.eq_obj2id)[end][tie])
    if int(found.eq_objtype[tie]) == _SITE:
        body, place = int(found.site_bodyid[number]), data.site_xpos[number]
    else:
        body, own = number, np.array(found.eq_data[tie, anchor : anchor + 3])
        place = data.xpos[body] + data.xmat[body] @ own
    offset = dynamics.point_offset(data, place)
    gained = (dynamics.moves(found, body) * data.qvel) @ data.cdof_dot
    turning, moving = gained[:3], gained[3:]
    speed = dynamics.point_velocity(data, body, offset)
    return moving + jnp.cross(turning, offset) + jnp.cross(data.cvel[body, :3], speed)
