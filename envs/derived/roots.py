"""How the first body of a file moves: freely, or in the plane; all else is refused."""

from typing import Any

import numpy as np

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.derived.source import FREE, joints_of, kind_of


def check(model: Any) -> None:
    """Raises ValueError unless there is one tree of bodies, under the Earth's gravity."""
    if model.nbody < 2:
        raise ValueError("the file has no body; add one to <worldbody>")
    for body in range(2, model.nbody):
        if not int(model.body_parentid[body]):
            raise ValueError(
                f"body {model.body(body).name} lies beside {model.body(1).name}; remove it"
            )
        for joint in joints_of(model, body):
            if int(model.jnt_type[joint]) == FREE:
                raise ValueError(
                    f"body {model.body(body).name} has a free joint inside the tree; remove it"
                )
    if int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_GRAVITY):
        raise ValueError("a <flag> disables gravity, without which nothing walks; remove it")
    gravity = model.opt.gravity
    if np.any(np.abs(gravity[:2]) > 1e-6) or not np.isclose(gravity[2], -9.81, atol=0.02):
        x, y, z = gravity
        raise ValueError(
            f"gravity is {x:g} {y:g} {z:g} m/s^2, and here it is 0 0 -9.81; change the <option>"
        )


def is_planar(model: Any) -> bool:
    """Returns whether the root moves in the plane of x and z.

    Raises:
      ValueError: it moves by other joints.
    """
    joints = joints_of(model, 1)
    kinds = [kind_of(model, joint) for joint in joints]
    if kinds == ["free"] or sorted(kinds) in (
        ["hinge"] * 3 + ["slide"] * 3,
        ["ball"] + ["slide"] * 3,
    ):
        return False
    slides = [model.jnt_axis[joint] for joint in joints if kind_of(model, joint) == "slide"]
    hinges = [model.jnt_axis[joint] for joint in joints if kind_of(model, joint) == "hinge"]
    flat = sorted(kinds) == ["hinge", "slide", "slide"] and (
        all(abs(axis[1]) < 1e-6 for axis in slides) and abs(hinges[0][1]) > 0.999
    )
    if flat:
        return True
    name = model.body(1).name or "number 1"
    raise ValueError(
        f"body {name} {_moves(kinds)}; the first body of a walker needs a <freejoint/>, or slides "
        "along x and z and a hinge about y to walk in the plane"
    )


def _moves(kinds: list[str]) -> str:
    """Returns how joints of these kinds let a root move."""
    if sorted(kinds) == ["hinge", "slide", "slide"]:
        return "moves in another plane than that of x and z"
    nums = [(kind, kinds.count(kind)) for kind in sorted(set(kinds), reverse=True)]
    words = [f"one {kind}" if num == 1 else f"{num} {kind}s" for kind, num in nums]
    return f"moves by {' and '.join(words)} alone" if words else "is fixed to the world"
