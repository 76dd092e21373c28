"""Which tree of a user's file is the robot, and what stands beside it."""

from typing import Any

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import kept as mjcf_kept
from mjxwalk.envs.mjcf.kept import Kept
from mjxwalk.envs.mjcf.notes import listed, said

_SIDES = (  # word, of one, of many
    ("moved from outside", "is moved from outside (mocap)", "are moved from outside (mocap)"),
    ("moving", "moves beside the robot", "move beside the robot"),
    ("standing", "stands beside the robot", "stand beside the robot"),
)


def find(model: Any, notes: list[str]) -> int:
    """Returns the body whose tree has the most joints, and the most actuators of those.

    Raises:
      ValueError: there are no bodies, none has a joint, or two trees are alike.
    """
    roots = [body for body in range(1, model.nbody) if not model.body_parentid[body]]
    if not roots:
        raise ValueError("it has no bodies; a robot is a <body> with joints in <worldbody>")
    sizes = {root: _size(model, root) for root in roots}
    most = max(sizes.values())
    best = [root for root in roots if sizes[root] == most]
    names = {root: str(model.body(root).name) for root in roots}
    if not most[0]:
        raise ValueError("it has no joints; a robot needs some to walk")
    if len(best) > 1:
        one, two = (names[root] or f"number {root}" for root in best[:2])
        raise ValueError(
            f"the bodies {one} and {two} have as many joints and actuators each, {most[0]} and "
            f"{most[1]}; leave one robot in it"
        )
    sides: dict[str, list[str]] = {}
    for root in roots:
        if root == best[0]:
            continue
        kind = "moving" if sizes[root][0] else "standing"
        if model.body_mocapid[root] >= 0:
            kind = "moved from outside"
        sides.setdefault(kind, []).append(names[root])
    for kind, verb, verbs in _SIDES:
        if kind in sides:
            num = len(sides[kind])
            rest = "it is left out" if num == 1 else "they are left out"
            notes.append(said(f"{listed('body', sides[kind], verb, verbs)}; {rest}"))
    return best[0]


def check(kept: Kept) -> None:
    """Raises ValueError unless the robot is of rigid bodies that no plugin moves."""
    model = kept.model
    for flex in range(model.nflex):
        first, num = int(model.flex_vertadr[flex]), int(model.flex_vertnum[flex])
        owners = {int(each) for each in model.flex_vertbodyid[first : first + num]}
        if owners & set(kept.bodies):
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_FLEX, flex)
            raise ValueError(
                f"the robot has a soft part, flex {name}; remove it, as bodies here are rigid"
            )
    for body, name in kept.bodies.items():
        if model.body_plugin[body] >= 0:
            raise ValueError(f"body {name} is moved by a plugin; remove it, as none runs here")
    for joint, name in kept.joints.items():
        damping = float(model.dof_damping[int(model.jnt_dofadr[joint])])
        if damping < 0.0:
            raise ValueError(
                f"joint {name} has a damping of {damping:g}, which drives it; write 0 or more"
            )
    for actuator in kept.actuators:
        if model.actuator_plugin[actuator] >= 0:
            name = model.actuator(actuator).name or f"number {actuator}"
            raise ValueError(f"actuator {name} is run by a plugin; write <motor> or <position>")


def note_scenery(kept: Kept, notes: list[str]) -> None:
    """Says which geoms of the world are left out."""
    model = kept.model
    left = [
        geom
        for geom in range(model.ngeom)
        if not model.geom_bodyid[geom] and geom not in kept.floors and _touches(model, geom)
    ]
    if left:
        names = [str(model.geom(geom).name) for geom in left]
        rest = "it is left out" if len(left) == 1 else "they are left out"
        text = listed("geom", names, "stands beside the robot", "stand beside the robot")
        notes.append(said(f"{text}; {rest}"))


def _touches(model: Any, geom: int) -> bool:
    return bool(model.geom_contype[geom] or model.geom_conaffinity[geom])


def _size(model: Any, root: int) -> tuple[int, int]:
    """Returns how many joints a tree has, and how many actuators drive them."""
    bodies = {body for body in range(1, model.nbody) if mjcf_kept.top(model, body) == root}
    joints = sum(int(model.body_jntnum[body]) for body in bodies)
    driving = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    actuators = [
        actuator
        for actuator in range(model.nu)
        if int(model.actuator_trntype[actuator]) in driving
        and int(model.jnt_bodyid[int(model.actuator_trnid[actuator][0])]) in bodies
    ]
    return joints, len(actuators)
