"""What walkers sense, worked out from their coordinates as the anatomy tells."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.envs import Anatomy
from mjxwalk.envs.anatomy import Root, Sense

COUNTED = ("time", "contact", "ankle_x")  # senses that are not of coordinates
ROLES = ("forward", "sideways", "height", "yaw", "pitch", "roll")  # of the root's coordinates
OF_RATES = {"rad": False, "m": False, "rad/s": True, "m/s": True}


def places(anatomy: Anatomy, sense: Sense) -> list[int] | None:
    """Returns the places of the coordinates that a sense has; None if it has no such places."""
    known: dict[str, int | None] = {role: getattr(anatomy.root, role) for role in ROLES}
    known |= {name: place for place, name in enumerate(anatomy.names)}
    names = sense.order or (sense.name.removesuffix("_rate"),)
    found = [known.get(name) for name in names]
    if sense.unit not in OF_RATES or None in found:
        return None
    return [place for place in found if place is not None]


class Torso(NamedTuple):
    """How the torsos of several walkers are turned and move.

    Attributes:
      axes: of each, as columns.
      spin: angular velocity, world axes, rad/s.
      velocity: of the origin, world axes, m/s.
    """

    axes: Float[np.ndarray, "walker 3 3"]
    spin: Float[np.ndarray, "walker 3"]
    velocity: Float[np.ndarray, "walker 3"]

    @classmethod
    def of(cls, root: Root, qpos: Any, qvel: Any) -> "Torso":
        """Returns that of coordinates [walker, coordinate] and their rates.

        Each turn is about an axis of the body as the turns before have left it.
        """
        axes = np.broadcast_to(np.eye(3), (len(qpos), 3, 3))
        spin, velocity = np.zeros((2, len(qpos), 3))
        for place, axis in ((root.yaw, 2), (root.pitch, 1), (root.roll, 0)):
            if place is not None:
                spin = spin + qvel[:, [place]] * axes[:, :, axis]
                axes = axes @ _turn(axis, qpos[:, place])
        for place, axis in ((root.forward, 0), (root.sideways, 1), (root.height, 2)):
            if place is not None:
                velocity[:, axis] = qvel[:, place]
        return cls(axes, spin, velocity)

    def within(self, vector: Any) -> Any:
        """Returns vectors [walker, 3] in the axes of the torsos."""
        return (vector[:, None] @ self.axes)[:, 0]


# Senses of the torso in its own axes, by name; elements are named by axes.
OF_TORSO: Mapping[str, Callable[[Torso], Any]] = {
    "up": lambda torso: torso.axes[:, 2],
    "turning": lambda torso: torso.within(torso.spin),
    "velocity": lambda torso: torso.within(torso.velocity),
}


def known(anatomy: Anatomy, sense: Sense) -> bool:
    """Returns whether a sense can be worked out here."""
    if sense.name in OF_TORSO and sense.order:
        return set(sense.order) <= set("xyz")
    nothing = sense.name == "heading" and anatomy.root.is_planar
    return nothing or sense.name in COUNTED or places(anatomy, sense) is not None


class Senses:
    """The senses of a body, for several walkers at once."""

    def __init__(self, anatomy: Anatomy, like: Any) -> None:
        """Reads what there is to sense.

        Args:
          anatomy: of the body, whose senses are `known`.
          like: what one walker senses, with the shapes of its fields.
        """
        self._anatomy, self._like = anatomy, like

    def of(self, qpos: Any, qvel: Any, counted: Mapping[str, Any]) -> Any:
        """Returns what walkers sense, leaves [walker, ...].

        Args:
          qpos: coordinates [walker, coordinate].
          qvel: their rates.
          counted: the senses in COUNTED, by name.
        """
        torso = Torso.of(self._anatomy.root, qpos, qvel)
        found: dict[str, Any] = {}
        for sense in self._anatomy.senses:
            if sense.name in COUNTED:
                found[sense.name] = counted[sense.name]
                continue
            value = self._one(sense, torso, qpos, qvel)
            shape = getattr(self._like, sense.name).shape
            found[sense.name] = value.reshape(len(qpos), *shape)
        return self._like._replace(**found)

    def _one(self, sense: Sense, torso: Torso, qpos: Any, qvel: Any) -> Any:
        if sense.name in OF_TORSO and sense.order:
            parts = OF_TORSO[sense.name](torso)
            return parts[:, ["xyz".index(axis) for axis in sense.order]]
        where = places(self._anatomy, sense)
        return (qvel if OF_RATES[sense.unit] else qpos)[:, [] if where is None else where]


def _turn(axis: int, angle: Any) -> Any:
    """Returns matrices [walker, 3, 3] that turn about an axis."""
    found = np.zeros((len(angle), 3, 3))
    first, second = (axis + 1) % 3, (axis + 2) % 3
    found[:, axis, axis] = 1.0
    found[:, first, first] = found[:, second, second] = np.cos(angle)
    found[:, second, first], found[:, first, second] = np.sin(angle), -np.sin(angle)
    return found
