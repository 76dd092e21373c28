"""What is known of a body beside its model: which coordinate is what, where it touches the ground.

Whoever shows, measures, films or exports a body reads its anatomy, so that no tool knows a body by
name. It is derived from the compiled model and the few things that a file of ours does not say.
"""

import re
from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from mjxwalk.envs._mujoco import mujoco

Side = Literal["left", "right", "middle"]
LEGS: tuple[Side, Side] = ("left", "right")
SLIDE, HINGE = int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE)
KINDS: Mapping[int, Literal["slide", "hinge"]] = {SLIDE: "slide", HINGE: "hinge"}
_SIDES = re.compile(r"(?i)(?<![a-z])(left|right|l|r)(?![a-z])|(left|right)")
MIRROR = np.diag([1.0, -1.0, 1.0])  # left and right change places


class Coordinate(NamedTuple):
    """A number of `State.qpos`.

    Attributes:
      name: of the joint that it moves; without the side where it moves one of each leg.
      kind: "slide", m, or "hinge", rad.
      side: whose leg's it is; "middle" of all others.
      mirror: place of its partner on the other side; its own of a middle one.
      sign: by which the partner's value is multiplied as left and right change places.
      lower: where its range begins; minus infinity where it has none.
      upper: where its range ends; infinity where it has none.
    """

    name: str
    kind: Literal["slide", "hinge"]
    side: Side
    mirror: int
    sign: float
    lower: float
    upper: float

    @property
    def unit(self) -> str:
        """Of the coordinate: "m" or "rad"."""
        return "m" if self.kind == "slide" else "rad"

    @property
    def words(self) -> str:
        """Its name without the side, to show."""
        return without_side(self.name).replace("_", " ")


class Root(NamedTuple):
    """How the body moves in the world: the places of these coordinates, None where it has none.

    Attributes:
      num: of coordinates of the root, which come first.
      forward: along x.
      sideways: along y.
      height: along z.
      yaw: about z, turning left positive.
      pitch: about y, leaning forward positive.
      roll: about x, leaning right positive.
    """

    num: int
    forward: int
    sideways: int | None
    height: int
    yaw: int | None
    pitch: int
    roll: int | None

    @property
    def is_planar(self) -> bool:
        """Whether the body moves in the plane of x and z."""
        return self.sideways is None

    @property
    def num_slides(self) -> int:
        """Coordinates that are places: two in the plane, three in space."""
        return 2 if self.is_planar else 3


class Motor(NamedTuple):
    """What drives a coordinate; motors are in the order of an action.

    Attributes:
      coordinate: its place.
      name: of the coordinate.
      law: "torque" of a motor that gives what `Action` asks for, "position" of one that a policy
        gives a target, "velocity" of one that goes to a desired angle as fast and as strongly as it
        can.
      lowest: torque that it can give at least, N m; minus infinity where it is not limited.
      highest: torque that it can give at most, N m; infinity where it is not limited.
      strength: torque, N m, or for other laws angle, rad, for an action of 1 where a policy has to
        act by numbers from -1 to 1.
      centre: what an action of 0 asks for there.
      damping: that such policies get beside their torque, N m s/rad.
      stiffness: of the law "position", N m/rad.
    """

    coordinate: int
    name: str
    law: Literal["torque", "position", "velocity"]
    lowest: float
    highest: float
    strength: float
    centre: float
    damping: float
    stiffness: float = 0.0


class ContactPoint(NamedTuple):
    """A point of a foot that touches the ground.

    Attributes:
      name: of it.
      body: name of the foot's body.
      side: of its leg.
      offset: from the body's origin in its axes, m.
      radius: of a sphere about the point, whose lowest point it is that touches; 0 for the point.
    """

    name: str
    body: str
    side: Side
    offset: tuple[float, float, float]
    radius: float


class Leg(NamedTuple):
    """A leg, and the places of its coordinates by role, None where it has none of the role.

    Attributes:
      side: of it.
      foot: name of its last body.
      hip: bends the whole leg forward and backward.
      knee: bends what is below it.
      ankle: bends the foot.
      bodies: that touch the ground; () where the foot alone does.
      ahead: direction in the foot's axes that leads forward as the body stands.
    """

    side: Side
    foot: str
    hip: int | None
    knee: int | None
    ankle: int | None
    bodies: tuple[str, ...] = ()
    ahead: tuple[float, float, float] = (1.0, 0.0, 0.0)


class Sense(NamedTuple):
    """A field of what the walker senses.

    Attributes:
      name: of the field of the observation.
      unit: "" where there is none.
      meaning: in a few words.
      order: what each element is, row by row; () where the meaning says so.
    """

    name: str
    unit: str
    meaning: str
    order: tuple[str, ...] = ()


class Anatomy(NamedTuple):
    """A body as its tools see it.

    Attributes:
      name: of the body.
      coordinates: in the order of `State.qpos`.
      joint_coordinate: place of the coordinate that moves each joint of the model.
      root: how the body moves in the world.
      torso: name of the body that the root's joints move.
      motors: in the order of an action.
      points: where it touches the ground, in the order of `State.touching`.
      legs: left, then right; of more than two, pairs from front to hind.
      senses: what is sensed, in order.
    """

    name: str
    coordinates: tuple[Coordinate, ...]
    joint_coordinate: tuple[int, ...]
    root: Root
    torso: str
    motors: tuple[Motor, ...]
    points: tuple[ContactPoint, ...]
    legs: tuple[Leg, ...]
    senses: tuple[Sense, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return tuple(each.name for each in self.coordinates)

    @property
    def driven(self) -> Int[np.ndarray, " motor"]:
        """Places of the coordinates that have a motor."""
        return np.array([motor.coordinate for motor in self.motors], np.int32)

    @property
    def first_joint(self) -> Int[np.ndarray, " coordinate"]:
        """The first joint that each coordinate moves."""
        return np.unique(np.array(self.joint_coordinate), return_index=True)[1]

    @property
    def coupling(self) -> Float[np.ndarray, "joint coordinate"] | None:
        """Rates of the joints as a matrix times those of the coordinates; None if they are one."""
        if len(self.joint_coordinate) == len(self.coordinates):
            return None
        return np.eye(len(self.coordinates), dtype=np.float32)[np.array(self.joint_coordinate)]

    def place(self, name: str) -> int:
        """Returns the place of the coordinate of a name.

        Raises:
          ValueError: the body has none.
        """
        if name not in self.names:
            raise ValueError(f"{self.name} has no {name}; it has {', '.join(self.names)}")
        return self.names.index(name)

    def heel_and_toe(self, leg: Leg) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
        """Returns the middle of a foot's hind contact points, and of its front ones, m.

        Both are in the foot's axes; of a foot with one point they are that point.
        """
        places = np.array([point.offset for point in self.points if point.body == leg.foot])
        along = places @ np.array(leg.ahead)
        front = along > along.mean()
        heel, toe = (
            places[~front].mean(axis=0),
            places[front if front.any() else ~front].mean(axis=0),
        )
        return heel, toe

    def points_of(self, leg: Leg) -> list[int]:
        """Returns the places of a foot's contact points."""
        bodies = leg.bodies or (leg.foot,)
        return [place for place, point in enumerate(self.points) if point.body in bodies]


def side_of(name: str) -> Side:
    """Returns the side that a name speaks of: left, right, l or r as a word of it."""
    sides = {(first or second)[0].lower() for first, second in _SIDES.findall(_words(name))}
    return "left" if sides == {"l"} else "right" if sides == {"r"} else "middle"


def without_side(name: str) -> str:
    """Returns a name without the words for its side."""
    return re.sub(r"[_\-. ]+", "_", _SIDES.sub("", _words(name))).strip("_")


def _words(name: str) -> str:
    """Returns a name in which a capital letter begins a word: RightFoot is Right_Foot."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name)


def anatomy_of(env: object) -> Anatomy | None:
    """Returns the anatomy of an environment's body; None of one that has none."""
    return getattr(env, "anatomy", None)


def is_spatial(env: object) -> bool:
    """Returns whether an environment has a body that moves in space."""
    anatomy = anatomy_of(env)
    return anatomy is not None and not anatomy.root.is_planar
