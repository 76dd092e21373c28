"""Terrain as data: rows of heights that walkers share, made by a seeded random walk."""

import dataclasses
import functools
from typing import Any, NamedTuple, Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from mjxwalk.envs import checks, edge


class Terrain(NamedTuple):
    """The ground under one walker.

    A population shares one table, so that no walker holds a copy of its row.

    Attributes:
      heights: m, one terrain a row: a node every `spacing` metres along x, and in space across,
        along y.
      row: which terrain this walker walks on.
      course: what lies along the way on top of that, a course a row, as `mjxwalk.envs.Course`
        samples them; None for nothing.
    """

    heights: Float[Array, " terrain *node"]
    row: Int[Array, ""]
    course: Float[Array, "terrain place channel"] | None = None


class Patch(NamedTuple):
    """The nodes of one ground between some places.

    Attributes:
      x: of the first node, m.
      y: of the first row of nodes, m; ground that is the same at all y has one row.
      spacing: of the nodes, m.
      heights: of the nodes, m; numpy.
    """

    x: float
    y: float
    spacing: float
    heights: Float[np.ndarray, "row place"]


@runtime_checkable
class Ground(Protocol):
    """The shape of random ground."""

    @property
    def roughness(self) -> float:
        """Step between neighbouring nodes, m."""
        ...

    def height(
        self, terrain: Terrain, x: Float[Array, ""], y: Float[Array, ""] | None = None, /
    ) -> Float[Array, ""]:
        """Returns the ground's height at a place, m; ground in the plane ignores y."""
        ...

    def patch(self, heights: Any, x: tuple[float, float], y: tuple[float, float], /) -> Patch:
        """Returns the part of one ground that reaches from one place to another.

        Args:
          heights: of the ground, as `sample` returns them for each.
          x: first and last, m.
          y: first and last, m.
        """
        ...


@dataclasses.dataclass(frozen=True, kw_only=True)
class RandomWalk:
    """Rough ground in the plane: a random walk of heights over equally spaced nodes.

    Solomon et al. (2013), section 2.2: nodes 0.1 m apart, flat up to the toes, heights over a step
    with a standard deviation of 5.4 % of leg length. Their recursion is lost; ours is
    h[i+1] = h[i] +- roughness with equal probability, and a roughness of 0.02 m gives that figure.

    Attributes:
      roughness: step between neighbouring nodes, m.
      spacing: between nodes, m.
      flat_until: ground is at height zero up to here, m.
      start: where the first node lies, m.
      length: of the whole terrain, m; the ends go on level.
    """

    roughness: float = 0.02
    spacing: float = 0.1  # section 2.2
    flat_until: float = 0.4  # ours: the first node beyond the toes of the planar body at its start
    start: float = -2.0  # ours: room for a fall backwards
    length: float = 102.4  # ours: farther than any trial reaches

    def __post_init__(self) -> None:
        checks.not_negative(self, "roughness")
        checks.positive(self, "spacing", "length")
        checks.finite(self, "flat_until", "start")
        checks.nodes(self, "length")
        if self.length < 2 * self.spacing:
            raise ValueError(f"length must hold two nodes, got {self.length} m")

    @property
    def num_nodes(self) -> int:
        """Nodes of one terrain."""
        return round(self.length / self.spacing)

    def sample(self, key: PRNGKeyArray, num: int) -> Float[Array, "terrain node"]:
        """Returns the heights of `num` independent terrains, m."""
        nodes = self.start + self.spacing * np.arange(self.num_nodes)
        rough = nodes > self.flat_until + 0.5 * self.spacing
        return _walk(key, rough, self.roughness, num=num)

    def patch(self, heights: Any, x: tuple[float, float], y: tuple[float, float], /) -> Patch:
        """Returns the part of one ground between two places along x; its ends go on level."""
        del y
        first, along = nodes_along(self.start, self.spacing, x, self.num_nodes)
        return Patch(first, 0.0, self.spacing, np.asarray(heights)[along][None])

    def height(
        self, terrain: Terrain, x: Float[Array, ""], y: Float[Array, ""] | None = None
    ) -> Float[Array, ""]:
        """Returns the ground's height at x by linear interpolation, m; it is the same at all y."""
        del y
        edge.check_terrain(terrain, (self.num_nodes,))
        last = self.num_nodes - 1
        position = jnp.clip((x - self.start) / self.spacing, 0.0, last)
        # The last interval also serves x beyond the end; NaN becomes node 0.
        node = jnp.minimum(position.astype(jnp.int32), last - 1)
        fraction = position - node
        pair = jax.lax.dynamic_slice(terrain.heights, (terrain.row, node), (1, 2))[0]
        return pair[0] + fraction * (pair[1] - pair[0])


def nodes_along(
    start: float, spacing: float, x: tuple[float, float], num: int
) -> tuple[float, Int[np.ndarray, " place"]]:
    """Returns where the first node of a part of the ground lies, m, and which nodes it has."""
    first, last = int(np.floor((x[0] - start) / spacing)), int(np.ceil((x[1] - start) / spacing))
    return start + spacing * first, np.clip(np.arange(first, last + 1), 0, num - 1)


@functools.partial(jax.jit, static_argnames="num")
def _walk(
    key: PRNGKeyArray,
    rough: Bool[np.ndarray, " node"] | Bool[Array, " node"],
    step: float | Float[Array, ""],
    *,
    num: int,
) -> Float[Array, "{num} node"]:
    """Returns random walks that stand still where it is not rough."""
    coins = jax.random.rademacher(key, (num, rough.size), jnp.int32)
    return step * jnp.cumsum(jnp.where(rough, coins, 0), axis=1).astype(jnp.float32)
