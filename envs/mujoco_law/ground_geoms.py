"""Which geoms of a body may touch the ground, and where."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from mjxwalk.envs import frames
from mjxwalk.envs.derived import points as mjcf_points
from mjxwalk.envs.derived.source import Pose
from mjxwalk.envs.mujoco_law.ground import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    MESH,
    SPHERE,
    GroundContacts,
)
from mjxwalk.envs.mujoco_law.layout import ROOT

# ours: share of the root's height; walkers that stand and walk touch the ground with what is lower.
HIGH = 0.05


def find(pose: Pose, model: Any, contact: Any, floors: Sequence[int]) -> list[GroundContacts]:
    """Returns the points of all geoms that collide with a floor, by dimension and how they start.

    Args:
      pose: that trials start in, of the file.
      model: the `mujoco.MjModel` with the floors.
      contact: `mujoco.MjData.contact` where all of them touch one.
      floors: numbers of the geoms that the ground replaces.
    """
    pairs = np.asarray(contact.geom)
    of_geom: dict[int, int] = {}  # a contact with a floor, for what it says of margin, friction ...
    for place, (one, two) in enumerate(pairs.tolist()):
        for floor, geom in ((one, two), (two, one)):
            if floor in floors and geom not in floors:
                of_geom.setdefault(geom, place)
    found: list[GroundContacts] = []
    high = _high(pose, model, list(of_geom))
    for dim in (1, 3, 4, 6):
        for is_rare in (False, True):
            geoms = [
                geom
                for geom, place in of_geom.items()
                if int(contact.dim[place]) == dim and (geom in high) == is_rare
            ]
            if geoms:
                found.append(_of_geoms(pose, model, contact, geoms, of_geom, is_rare))
    return found


def _high(pose: Pose, model: Any, geoms: list[int]) -> set[int]:
    """Returns the geoms that start far above the lowest, in terms of the root's height there."""
    lowest: list[float] = []
    for geom in geoms:
        body = model.geom_bodyid[geom]
        turn = pose.data.xmat[body].reshape(3, 3)
        centre, size = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        up = turn[2] @ frames.matrix(model.geom_quat[geom])
        height = pose.data.xpos[body][2] + turn[2] @ model.geom_pos[geom]
        lowest.append(height + up @ centre - np.abs(up) @ size)
    if not lowest:
        return set()
    least = min(lowest)
    most = least + HIGH * (pose.data.xpos[ROOT][2] - least)
    return {geom for geom, height in zip(geoms, lowest, strict=True) if height > most}


def _of_geoms(
    pose: Pose,
    model: Any,
    contact: Any,
    geoms: list[int],
    of_geom: dict[int, int],
    is_rare: bool,
) -> GroundContacts:
    shapes: list[tuple[int, tuple[int, ...]]] = []
    corners: list[Any] = []
    owners: list[int] = []
    for kind in (SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH):
        own = tuple(geom for geom in geoms if int(model.geom_type[geom]) == kind)
        if not own:
            continue
        shapes.append((kind, own))
        if kind == MESH:
            # A floor that was added is of the world's geoms, which come before all others.
            added = model.ngeom - pose.model.ngeom
            corners += [_mesh_corners(pose, geom - added) for geom in own]
            num = [len(each) for each in corners]
        else:
            num = [{SPHERE: 1, CAPSULE: 2, ELLIPSOID: 1, CYLINDER: 4, BOX: 4}[kind]] * len(own)
        owners += [geom for geom, each in zip(own, num, strict=True) for _ in range(each)]
    places = np.array([of_geom[geom] for geom in owners])
    rules = {
        name: np.asarray(getattr(contact, name))[places]
        for name in ("friction", "solref", "solreffriction", "solimp")
    }
    return GroundContacts(
        dim=int(contact.dim[places[0]]),
        shapes=tuple(shapes),
        corners=tuple(corners),
        geom=np.array(owners),
        body=np.asarray(model.geom_bodyid)[owners],
        margin=np.asarray(contact.includemargin)[places],
        is_rare=is_rare,
        **rules,
    )


def _mesh_corners(pose: Pose, geom: int) -> Float[np.ndarray, "corner 3"]:
    """Returns the points of a mesh that may touch the ground.

    ours: as contact law points has them, those of the lower half as the body stands; C MuJoCo takes
    the lowest three that it finds in each step.

    Args:
      geom: its number in the file's model.
    """
    chosen = mjcf_points.spread(mjcf_points.lower(pose, geom))
    offsets = np.array([each.offset for each in chosen]) - pose.model.geom_pos[geom]
    return offsets @ frames.matrix(pose.model.geom_quat[geom])
