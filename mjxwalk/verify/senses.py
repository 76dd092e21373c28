"""What walkers sense, worked out from their coordinates as the anatomy tells."""

from collections.abc import Mapping
from typing import Any

from mjxwalk.envs import Anatomy
from mjxwalk.envs.anatomy import Sense

COUNTED = ("time", "contact", "ankle_x")  # senses that are not of coordinates
ROLES = ("forward", "sideways", "height", "yaw", "pitch", "roll")  # of the root's coordinates
OF_RATES = {"rad": False, "m": False, "rad/s": True, "m/s": True}


def places(anatomy: Anatomy, sense: Sense) -> list[int] | None:
    """Returns the places of the coordinates that a sense has; None if it is no sense of these."""
    known: dict[str, int | None] = {role: getattr(anatomy.root, role) for role in ROLES}
    known |= {name: place for place, name in enumerate(anatomy.names)}
    names = sense.order or (sense.name.removesuffix("_rate"),)
    found = [known.get(name) for name in names]
    if sense.unit not in OF_RATES or None in found:
        return None
    return [place for place in found if place is not None]


class Senses:
    """The senses of a body, for several walkers at once."""

    def __init__(self, anatomy: Anatomy, like: Any) -> None:
        """Reads what there is to sense.

        Args:
          anatomy: of the body; `places` knows its senses, or they are in COUNTED.
          like: what one walker senses, with the shapes of its fields.
        """
        self._like = like
        self._counted = [each.name for each in anatomy.senses if each.name in COUNTED]
        self._seen = [
            (each.name, OF_RATES[each.unit], places(anatomy, each), getattr(like, each.name).shape)
            for each in anatomy.senses
            if each.name not in COUNTED
        ]

    def of(self, qpos: Any, qvel: Any, counted: Mapping[str, Any]) -> Any:
        """Returns what walkers sense, leaves [walker, ...].

        Args:
          qpos: coordinates [walker, coordinate].
          qvel: their rates.
          counted: the senses in COUNTED, by name.
        """
        found = {name: counted[name] for name in self._counted}
        for name, of_rates, where, shape in self._seen:
            found[name] = (qvel if of_rates else qpos)[:, where].reshape(-1, *shape)
        return self._like._replace(**found)
