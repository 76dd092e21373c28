"""Which side of a walker each body of its model is on, to colour what is drawn of it."""

from typing import Any

from mjxwalk.envs.anatomy import Anatomy, Side, side_of


def body_sides(model: Any, anatomy: Anatomy) -> tuple[Side, ...]:
    """Returns the side of each body of a model, the world's first.

    A body of a leg has its leg's, whatever its name says: only one of two may be called left. All
    others have what their name speaks of, and else their parent's.
    """
    chains = {leg: _chain(model, anatomy, leg.foot) for leg in anatomy.legs}
    found: list[Side] = ["middle"]
    for body in range(1, model.nbody):
        owners = [leg for leg, chain in chains.items() if body in chain]
        if len(owners) == 1:
            found.append(owners[0].side)
            continue
        own = side_of(str(model.body(body).name))
        parent = found[int(model.body_parentid[body])]
        found.append(parent if own == "middle" and not owners else own)
    return tuple(found)


def _chain(model: Any, anatomy: Anatomy, foot: str) -> set[int]:
    """Returns the bodies from a foot up to the torso, without it."""
    body, torso = int(model.body(foot).id), int(model.body(anatomy.torso).id)
    found: set[int] = set()
    while body not in (0, torso):
        found.add(body)
        body = int(model.body_parentid[body])
    return found
