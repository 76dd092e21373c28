"""Contacts among a body's own spheres and capsules, of which few touch at a time.

MJX has rows for all pairs in every step. Here all pairs are asked how far apart they are, and those
that touch take slots; what follows is computed for slots alone. Their number is bounded: pairs
beyond it do not touch. A sphere is a capsule of no length.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from mjxwalk.envs._mujoco import mjx
from mjxwalk.envs.mujoco_law import softness
from mjxwalk.envs.mujoco_law.ground import CAPSULE, SPHERE, Touches, Under
from mjxwalk.envs.mujoco_law.softness import Softness

LEAST = 12  # pairs; ours: fewer are as fast without slots
# Slots are computed by so many at once, each share if a walker of a vector has a pair for it. Ours:
# Gymnasium's Humanoid has a pair that touches in a quarter of the states of its trials, three in a
# fortieth; thrown about on the ground, where trials are over, it had seven at most.
SHARES = (2, 2, 8)
_BITS = 24  # pairs in a word, each a bit of it; float32 holds as many
_SMALL = 1e-12  # squares of lengths that point nowhere, m^2


class OwnPairs(NamedTuple):
    """Pairs of one dimension of contact: constants only.

    Attributes:
      softness: of their rows.
      geom: numbers of both geoms.
      bodies: of both.
      half: of each geom's length, that of a sphere 0, m.
      radius: m.
    """

    softness: Softness
    geom: Int[np.ndarray, "pair 2"]
    bodies: Int[np.ndarray, "pair 2"]
    half: Float[np.ndarray, "pair 2"]
    radius: Float[np.ndarray, "pair 2"]


class Slots(NamedTuple):
    """Pairs that touch.

    Attributes:
      pair: number of the pair in each slot; that of an empty one is any.
      filled: whether each slot has a pair.
    """

    pair: Int[Array, " slot"]
    filled: Bool[Array, " slot"]


def find(model: Any, ours: Any, data: Any) -> tuple[OwnPairs, ...]:
    """Returns the pairs of each dimension of contact; () if they are few, or of other shapes.

    Args:
      model: the `mujoco.MjModel`, without floors.
      ours: the same for MJX.
      data: an `mjx.Data` of it.
    """
    seen = mjx.kinematics(ours, data.replace(qpos=jnp.asarray(model.qpos0)))
    contact = mjx.collision(ours, seen)._impl.contact
    kinds = np.asarray(model.geom_type)[np.asarray(contact.geom)]
    if len(kinds) < LEAST or not np.isin(kinds, (SPHERE, CAPSULE)).all():
        return ()
    found: list[OwnPairs] = []
    for dim in sorted({int(each) for each in contact.dim}):
        own = np.flatnonzero(contact.dim == dim)
        geom = np.asarray(contact.geom)[own]
        names = ("includemargin", "friction", "solref", "solreffriction", "solimp")
        values = [np.asarray(getattr(contact, name), float)[own] for name in names]
        bodies = np.asarray(model.geom_bodyid)[geom]
        size = np.asarray(model.geom_size)[geom]
        is_sphere = np.asarray(model.geom_type)[geom] == SPHERE
        half = np.where(is_sphere, 0.0, size[..., 1])
        rows = softness.of_contacts(model, dim, bodies, *values)
        found.append(OwnPairs(rows, geom, bodies, half, size[..., 0]))
    return tuple(found)


def touching(pairs: OwnPairs, data: Any) -> tuple[Slots, ...]:
    """Returns slots of pairs that touch, in shares.

    Args:
      pairs: of one dimension.
      data: the `mjx.Data` with the places of geoms.
    """
    words: list[Array] = []
    for start in range(0, len(pairs.geom), _BITS):
        end = min(start + _BITS, len(pairs.geom))
        near = [_touches(pairs, each, data) for each in range(start, end)]
        bits = [jnp.where(is_near, 1 << bit, 0) for bit, is_near in enumerate(near)]
        words.append(sum(bits, start=jnp.zeros((), jnp.int32)))
    found: list[Slots] = []
    for size in SHARES:
        taken: list[tuple[Array, Array]] = []
        for _ in range(min(size, len(pairs.geom))):
            pair, filled, words = _taken(words)
            taken.append((pair, filled))
        found.append(Slots(*(jnp.stack(each) for each in zip(*taken, strict=True))))
    return tuple(found)


def is_rare(slots: Slots) -> bool:
    """Returns whether slots are of the last share."""
    return slots.pair.shape[0] == SHARES[-1]


def _taken(words: Sequence[Array]) -> tuple[Int[Array, ""], Bool[Array, ""], list[Array]]:
    """Returns the first pair whose bit is set, whether there is one, and the words without it."""
    pair, filled = jnp.zeros((), jnp.int32), jnp.zeros((), bool)
    rest: list[Array] = []
    for number, word in enumerate(words):
        is_here = ~filled & (word != 0)
        lowest = (word & -word).astype(jnp.float32)
        # The exponent of a power of two.
        bit = (jax.lax.bitcast_convert_type(lowest, jnp.int32) >> 23) - 127
        pair = jnp.where(is_here, number * _BITS + bit, pair)
        rest.append(jnp.where(is_here, word & (word - 1), word))
        filled = filled | is_here
    return pair, filled, rest


def _touches(pairs: OwnPairs, pair: int, data: Any) -> Bool[Array, ""]:
    """Returns whether a pair is within its margin."""
    one, other = (_segment(pairs, pair, end, data) for end in (0, 1))
    apart = _apart(one, other)
    reach = pairs.radius[pair].sum() + pairs.softness.margin[pair]
    return apart @ apart < float(reach) ** 2


class _Segment(NamedTuple):
    """A capsule's axis.

    Attributes:
      centre: m.
      along: from the centre to one end; None of a sphere.
      square: of its length; None where it is not known to be above zero.
    """

    centre: Float[Array, "3"]
    along: Float[Array, "3"] | None
    square: Any


def _segment(pairs: OwnPairs, pair: int, end: int, data: Any) -> _Segment:
    geom, half = int(pairs.geom[pair, end]), float(pairs.half[pair, end])
    centre = data.geom_xpos[geom]
    if not half:
        return _Segment(centre, None, None)
    return _Segment(centre, half * data.geom_xmat[geom][:, 2], half**2)


def _apart(one: _Segment, other: _Segment) -> Float[Array, "3"]:
    """Returns the shortest way from the first segment to the second, m."""
    first, second = _nearest(one, other)
    return second - first


def _nearest(one: _Segment, other: _Segment) -> tuple[Float[Array, "3"], Float[Array, "3"]]:
    """Returns the points of two segments that are nearest to each other (Ericson, 2005, 5.1.9)."""
    apart = other.centre - one.centre
    if one.along is None and other.along is None:
        return one.centre, other.centre
    if one.along is None or other.along is None:
        has, sign = (one, 1.0) if other.along is None else (other, -1.0)
        assert has.along is not None
        share = jnp.clip(sign * (apart @ has.along) / has.square, -1.0, 1.0)
        end = has.centre + share * has.along
        return (end, other.centre) if has is one else (one.centre, end)
    both = one.along @ other.along
    first, second = apart @ one.along, apart @ other.along
    # Of parallel ones all points are as near that lie side by side.
    slant = jnp.maximum(one.square * other.square - both * both, _SMALL)
    share = jnp.clip((first * other.square - both * second) / slant, -1.0, 1.0)
    far = jnp.clip((both * share - second) / other.square, -1.0, 1.0)
    share = jnp.clip((first + both * far) / one.square, -1.0, 1.0)
    return one.centre + share * one.along, other.centre + far * other.along


def touches(pairs: OwnPairs, slots: Slots, data: Any) -> Touches:
    """Returns how the pairs in slots touch; the normal is from the first geom to the second.

    Args:
      pairs: of one dimension.
      slots: of them.
      data: the `mjx.Data` with the places of geoms.
    """
    used, where = np.unique(pairs.geom, return_inverse=True)
    places = jnp.stack([data.geom_xpos[int(geom)] for geom in used])
    axes = jnp.stack([data.geom_xmat[int(geom)][:, 2] for geom in used])
    numbers = where.reshape(pairs.geom.shape)

    def one(pair: Array, filled: Array) -> Touches:
        ends: list[_Segment] = []
        for end in (0, 1):
            number = jnp.asarray(numbers[:, end])[pair]
            half = softness.picked(pairs.half[:, end], pair)
            along = half * axes[number]
            ends.append(_Segment(places[number], along, jnp.maximum(half * half, _SMALL)))
        first, second = _nearest(*ends)
        radii = [softness.picked(pairs.radius[:, end], pair) for end in (0, 1)]
        apart = second - first
        length = jnp.sqrt(jnp.maximum(apart @ apart, _SMALL))
        normal = apart / length
        distance = length - radii[0] - radii[1]
        place = first + normal * (radii[0] + 0.5 * distance)
        return Touches(distance, place, _frame(normal), filled, Under(jnp.zeros(())))

    return jax.vmap(one)(slots.pair, slots.filled)


def _frame(normal: Float[Array, "3"]) -> Float[Array, "3 3"]:
    """Returns rows of the normal and two axes across it, as MuJoCo chooses them."""
    y, z = (jnp.asarray(each, normal.dtype) for each in np.eye(3)[1:])
    first = jnp.where(jnp.abs(normal[1]) < 0.5, y, z)
    first = first - normal * (normal @ first)
    first = first / jnp.sqrt(first @ first)
    return jnp.stack([normal, first, jnp.cross(normal, first)])
