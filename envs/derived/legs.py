"""The legs of any tree: which bodies are feet, what carries them, and which side is which."""

import itertools
from typing import Any, NamedTuple

import numpy as np

from mjxwalk.envs.anatomy import Side, side_of
from mjxwalk.envs.derived.points import may_touch, of_geom
from mjxwalk.envs.derived.source import Pose, geoms_of, joints_of, parents

# ours: shares of the root's height over the lowest point, in the pose that trials start in.
LOW = 0.1  # bodies that reach down so far may be feet
SAME_FOOT = 0.03  # bodies of a leg that reach down so near to its lowest are its foot
CLOSE = 1e-3  # m; a leg nearer to the middle than this is on neither side
LYING = (
    0.15  # of a biped, height of the root over how far its farthest part is from it; below, it lies
)


class FileLeg(NamedTuple):
    """A leg of a file's tree.

    Attributes:
      side: "left", "right" or "middle".
      top: number of the first body that belongs to no other leg.
      foot: bodies that touch the ground; the first reaches farthest down the tree.
      joints: numbers of the joints from the top to the foot.
    """

    side: Side
    top: int
    foot: tuple[int, ...]
    joints: tuple[int, ...]


def find(pose: Pose) -> list[FileLeg]:
    """Returns the legs, pairs together, left before right, front before hind.

    Raises:
      ValueError: fewer than two are found.
    """
    model = pose.model
    lows = _lows(pose)
    if not lows:
        raise ValueError(
            "the body has no geoms that could touch the ground; give its feet <geom .../>, or "
            "sites named heel..., toe... or sole..."
        )
    floor = min(lows.values())
    height = float(pose.data.xpos[1][2]) - floor
    if height <= 0.0:
        raise ValueError(
            f"body {model.body(1).name} is lower than all it could stand on, in the pose that "
            "trials start in; add a <key> named home in which it stands"
        )
    feet = [body for body, low in lows.items() if low < floor + LOW * height]
    tops = _tops(model, 1, feet)
    legs = [_leg(pose, top, feet, lows, SAME_FOOT * height) for top in tops]
    if len(legs) < 2:
        named = " and ".join(str(model.body(body).name) or f"number {body}" for body in feet)
        raise ValueError(
            f"only one leg reaches the ground in the pose that trials start in (body {named}), and "
            "a walker needs two; if it has two, add a <key> named home in which it stands on both"
        )
    _check_upright(pose, legs, height)
    return _sided(pose, legs)


def _check_upright(pose: Pose, legs: list[FileLeg], height: float) -> None:
    """Raises ValueError if a body with two legs lies; what has more may be long and low."""
    model, data = pose
    places = [data.geom_xpos[geom] for geom in range(model.ngeom) if model.geom_bodyid[geom]]
    places += list(data.xpos[2:])
    far = max(float(np.linalg.norm(place - data.xpos[1])) for place in places)
    if len(legs) == 2 and height < LYING * far:
        raise ValueError(
            f"body {model.body(1).name or 'number 1'} lies in the pose that trials start in: it is "
            f"{height:.2g} m over the ground, and reaches {far:.2g} m; add a <key> named home in "
            "which it stands"
        )


def _lows(pose: Pose) -> dict[int, float]:
    """Returns how low each body reaches by the geoms that may touch the ground, m."""
    model = pose.model
    geoms = range(model.ngeom)
    colliding = [geom for geom in geoms if may_touch(model, geom)]
    lows: dict[int, float] = {}
    for geom in colliding or [each for each in geoms if int(model.geom_bodyid[each])]:
        heights = [height for _, _, height in of_geom(pose, geom)]
        body = int(model.geom_bodyid[geom])
        if heights:
            lows[body] = min(lows.get(body, np.inf), *heights, np.inf)
    for site in range(model.nsite):  # feet may be drawn by sites alone
        body = int(model.site_bodyid[site])
        if body and not list(geoms_of(model, body)):
            lows[body] = min(lows.get(body, np.inf), float(pose.data.site_xpos[site][2]))
    return lows


def _tops(model: Any, body: int, feet: list[int]) -> list[int]:
    """Returns the first body of each leg among those that a body carries."""
    carried = [each for each in feet if body in parents(model, each)]
    children = [
        child
        for child in range(1, model.nbody)
        if int(model.body_parentid[child]) == body
        and any(child in parents(model, each) for each in carried)
    ]
    if not children:
        return [body] if body in feet else []
    if body in feet and body > 1:  # a foot with toes
        return [body]
    found = [top for child in children for top in _tops(model, child, feet)]
    # A chain with one foot begins where it leaves the others.
    return [body] if body > 1 and len(found) == 1 else found


def _leg(pose: Pose, top: int, feet: list[int], lows: dict[int, float], same: float) -> FileLeg:
    model = pose.model
    own = [body for body in feet if top in parents(model, body)]
    floor = min(lows[body] for body in own)
    foot = [body for body in own if lows[body] <= floor + same]
    foot.sort(key=lambda body: -len(parents(model, body)))
    chain = [body for body in reversed(parents(model, foot[0])) if top in parents(model, body)]
    joints = tuple(joint for body in chain for joint in joints_of(model, body))
    return FileLeg("middle", top, tuple(foot), joints)


def _sided(pose: Pose, legs: list[FileLeg]) -> list[FileLeg]:
    """Returns the legs with their sides, by names, else by where they are, else by their order."""
    model, data = pose
    middle = float(np.mean([data.xpos[leg.foot[0]][1] for leg in legs]))

    def named(leg: FileLeg) -> Side:
        names = [str(model.body(body).name) for body in parents(model, leg.foot[0])]
        names = names[: len(parents(model, leg.foot[0])) - len(parents(model, leg.top)) + 1]
        names += [str(model.joint(joint).name) for joint in leg.joints]
        marks: list[Side] = [side for side in map(side_of, names) if side != "middle"]
        return marks[0] if len(set(marks)) == 1 else "middle"

    sides: list[Side] = [named(leg) for leg in legs]
    apart = [float(data.xpos[leg.foot[0]][1]) - middle for leg in legs]
    if "middle" in sides and all(abs(each) > CLOSE for each in apart):
        sides = ["left" if each > 0 else "right" for each in apart]
    elif len(legs) > 2 and set(sides) == {"middle"}:
        left, right = (sum(sign * each > CLOSE for each in apart) for sign in (1, -1))
        if left == right:  # as many on either side, and some in the middle
            sides = [
                "middle" if abs(each) <= CLOSE else "left" if each > 0 else "right"
                for each in apart
            ]
    elif len(legs) == 2 and sides.count("middle") == 1:
        known = sides[0] if sides[1] == "middle" else sides[1]
        other: Side = "right" if known == "left" else "left"
        sides = [other if side == "middle" else side for side in sides]
    elif len(legs) == 2 and sides.count("middle") == 2:
        sides = ["left", "right"]
    found = [leg._replace(side=side) for leg, side in zip(legs, sides, strict=True)]
    # Front to hind, left before right.
    ahead = sorted(found, key=lambda leg: -float(data.xpos[leg.foot[0]][0] + data.xpos[leg.top][0]))
    lines = [[leg for leg in ahead if leg.side == side] for side in ("left", "right")]
    pairs = [leg for pair in itertools.zip_longest(*lines) for leg in pair if leg is not None]
    return [*pairs, *(leg for leg in ahead if leg.side == "middle")]
