"""Which parts of a compiled model are the robot: its tree, and all that acts on it alone."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from mjxwalk.envs._mujoco import mujoco

_LEVEL = 0.999  # upward part of a floor's normal; ours: what is steeper is a wall


class Kept(NamedTuple):
    """The parts of a model that are written, by their places in it.

    Attributes:
      model: the `mujoco.MjModel`.
      bodies: names of the robot's bodies.
      joints: names of its joints.
      roots: bodies that hang from the world.
      floors: level planes of the world.
      colliding: geoms that may touch something.
      pairs: pairs of geoms that collide, both kept.
      tendons: of the robot alone.
      equalities: constraints of the robot alone.
      actuators: that act on the robot.
      coordinates: of the robot in qpos.
      velocities: of the robot in qvel.
      activations: of kept actuators in act.
      statistic: of the model, as far as the file gives it.
    """

    model: Any
    bodies: Mapping[int, str]
    joints: Mapping[int, str]
    roots: tuple[int, ...]
    floors: tuple[int, ...]
    colliding: frozenset[int]
    pairs: tuple[int, ...]
    tendons: tuple[int, ...]
    equalities: tuple[int, ...]
    actuators: tuple[int, ...]
    coordinates: tuple[int, ...]
    velocities: tuple[int, ...]
    activations: tuple[int, ...]
    statistic: Mapping[str, float]


_WIDTH = {0: (7, 6), 1: (4, 3), 2: (1, 1), 3: (1, 1)}  # of each kind of joint in qpos and qvel


def kept(model: Any, root: int, statistic: Mapping[str, float]) -> Kept:
    """Returns what belongs to the tree of a body, and the world's level planes."""
    inside = [body for body in range(1, model.nbody) if top(model, body) == root]
    bodies = _named([str(model.body(body).name) for body in inside], inside, "body")
    of_robot = [joint for joint in range(model.njnt) if int(model.jnt_bodyid[joint]) in bodies]
    joints = _named(
        [str(model.joint(joint).name) for joint in of_robot],
        of_robot,
        "joint",
        [bodies[int(model.jnt_bodyid[joint])] for joint in of_robot],
    )
    floors = tuple(geom for geom in range(model.ngeom) if _is_floor(model, geom))
    geoms = {geom for geom in range(model.ngeom) if int(model.geom_bodyid[geom]) in bodies}
    geoms |= set(floors)
    pairs = tuple(
        pair
        for pair in range(model.npair)
        if {int(model.pair_geom1[pair]), int(model.pair_geom2[pair])} <= geoms
    )
    tendons = tuple(each for each in range(model.ntendon) if _of_tendon(model, each, bodies))
    actuators = tuple(
        each for each in range(model.nactuator) if _of_actuator(model, each, bodies, tendons)
    )
    paired = {int(each[pair]) for pair in pairs for each in (model.pair_geom1, model.pair_geom2)}
    widths = [(_WIDTH[int(model.jnt_type[joint])], joint) for joint in of_robot]
    return Kept(
        model=model,
        bodies=bodies,
        joints=joints,
        roots=(root,),
        floors=floors,
        colliding=frozenset(
            geom
            for geom in geoms
            if model.geom_contype[geom] or model.geom_conaffinity[geom] or geom in paired
        ),
        pairs=pairs,
        tendons=tendons,
        equalities=tuple(
            each for each in range(model.neq) if _of_equality(model, each, bodies, tendons)
        ),
        actuators=actuators,
        coordinates=_places([(int(model.jnt_qposadr[joint]), num) for (num, _), joint in widths]),
        velocities=_places([(int(model.jnt_dofadr[joint]), num) for (_, num), joint in widths]),
        activations=_places(
            [
                (int(model.actuator_actadr[each]), int(model.actuator_actnum[each]))
                for each in actuators
                if model.actuator_actadr[each] >= 0
            ]
        ),
        statistic=statistic,
    )


def top(model: Any, body: int) -> int:
    """Returns the body in the world that a body hangs from."""
    while body and int(model.body_parentid[body]):
        body = int(model.body_parentid[body])
    return body


def _named(
    names: list[str], places: list[int], word: str, of: list[str] | None = None
) -> dict[int, str]:
    """Returns names by place; of those that have none, one that no other has."""
    taken = {each for each in names if each}
    found: dict[int, str] = {}
    for index, (name, place) in enumerate(zip(names, places, strict=True)):
        chosen = name or (f"{of[index]}_{word}" if of else f"{word}_{place}")
        number = 2
        while not name and chosen in taken:
            chosen = f"{of[index] if of else word}_{word}_{number}"
            number += 1
        taken.add(chosen)
        found[place] = chosen
    return found


def _places(runs: list[tuple[int, int]]) -> tuple[int, ...]:
    return tuple(first + place for first, num in runs for place in range(num))


def _is_floor(model: Any, geom: int) -> bool:
    if model.geom_bodyid[geom] or int(model.geom_type[geom]) != int(mujoco.mjtGeom.mjGEOM_PLANE):
        return False
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    return bool(turn[8] > _LEVEL)


def _of_tendon(model: Any, tendon: int, bodies: Mapping[int, str]) -> bool:
    """Returns whether a tendon leads along the robot alone."""
    first, num = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
    owners = {
        int(mujoco.mjtWrap.mjWRAP_JOINT): model.jnt_bodyid,
        int(mujoco.mjtWrap.mjWRAP_SITE): model.site_bodyid,
        int(mujoco.mjtWrap.mjWRAP_SPHERE): model.geom_bodyid,
        int(mujoco.mjtWrap.mjWRAP_CYLINDER): model.geom_bodyid,
    }
    return all(
        int(owners[int(model.wrap_type[wrap])][int(model.wrap_objid[wrap])]) in bodies
        for wrap in range(first, first + num)
        if int(model.wrap_type[wrap]) in owners
    )


def _of_actuator(
    model: Any, actuator: int, bodies: Mapping[int, str], tendons: tuple[int, ...]
) -> bool:
    kind, place = int(model.actuator_trntype[actuator]), int(model.actuator_trnid[actuator][0])
    if kind == int(mujoco.mjtTrn.mjTRN_TENDON):
        return place in tendons
    if kind == int(mujoco.mjtTrn.mjTRN_BODY):
        return place in bodies
    if kind in (int(mujoco.mjtTrn.mjTRN_SITE), int(mujoco.mjtTrn.mjTRN_SLIDERCRANK)):
        return int(model.site_bodyid[place]) in bodies
    return int(model.jnt_bodyid[place]) in bodies


def _of_equality(
    model: Any, equality: int, bodies: Mapping[int, str], tendons: tuple[int, ...]
) -> bool:
    kind = int(model.eq_type[equality])
    ends = [int(each[equality]) for each in (model.eq_obj1id, model.eq_obj2id)]
    if kind == int(mujoco.mjtEq.mjEQ_TENDON):
        return all(each in tendons for each in ends if each >= 0)
    if kind == int(mujoco.mjtEq.mjEQ_JOINT):
        return all(int(model.jnt_bodyid[each]) in bodies for each in ends if each >= 0)
    if int(model.eq_objtype[equality]) == int(mujoco.mjtObj.mjOBJ_SITE):
        return all(int(model.site_bodyid[each]) in bodies for each in ends)
    return any(each in bodies for each in ends) and all(each in bodies or not each for each in ends)
