"""Ground in space as data: grids of heights that walkers share, made by a seeded random walk.

Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and 3D bipedal
walking over rough terrain", Adaptive Behavior 21(1), doi 10.1177/1059712312462904, Appendix A.
"""

import dataclasses
import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray, UInt32

from mjxwalk.envs import checks, edge
from mjxwalk.envs.terrain import Patch, Terrain, nodes_along

FILTER_SIDE = 5  # nodes; Appendix A
MARGIN = FILTER_SIDE // 2  # nodes that the filter takes off every edge
WORD = 32  # bits
ALL = np.uint32(0xFFFFFFFF)


@dataclasses.dataclass(frozen=True, kw_only=True)
class SerpentineWalk:
    """Rough ground in space: two random walks in serpentines, averaged and smoothed.

    Solomon et al. (2013), Appendix A. Over 0.6 to 0.7 m, a step of the body `Flame`, heights spread
    by 1.17 times the roughness: 0.36, 1.8 and 3.6 % of its legs for 0.002, 0.01 and 0.02 m, where
    the paper has 0.36, 2.0 and 3.55 %.

    Attributes:
      roughness: the factor r, m.
      spacing: between nodes, m.
      flat_until: ground is at height zero up to here, m.
      start: where the first node lies, m.
      length: of the whole terrain, m; the ends go on level.
      width: of the whole terrain, m, half of it to either side; beyond, it goes on mirrored.
    """

    roughness: float = 0.002
    spacing: float = 0.1
    flat_until: float = 2.0
    start: float = -2.0  # ours: room for a fall backwards
    length: float = 102.4  # ours: farther than any trial reaches
    width: float = 6.4  # ours: a mirror image some way off costs no memory and flatters nobody

    def __post_init__(self) -> None:
        checks.not_negative(self, "roughness")
        checks.positive(self, "spacing", "length", "width")
        checks.finite(self, "flat_until", "start")
        checks.nodes(self, "length", "width")
        for field in ("length", "width"):
            if getattr(self, field) < 2 * self.spacing:
                raise ValueError(f"{field} must hold two nodes, got {getattr(self, field)} m")

    @property
    def num_nodes(self) -> tuple[int, int]:
        """Nodes of one terrain, along and across."""
        return round(self.length / self.spacing), round(self.width / self.spacing)

    def sample(self, key: PRNGKeyArray, num: int) -> Float[Array, "terrain along across"]:
        """Returns the heights of `num` independent terrains, m."""
        nodes = self.start + self.spacing * (np.arange(self.num_nodes[0] + 2 * MARGIN) - MARGIN)
        # The filter makes a slope of the step that is left where the flat part ends.
        flat = nodes < self.flat_until + (MARGIN + 0.5) * self.spacing
        across = self.num_nodes[1]
        # As many at once as a word has bits, so that what is compiled serves any number.
        sheets = [
            _sheets(jax.random.fold_in(key, block), flat, self.roughness, across=across)
            for block in range(-(-num // WORD))
        ]
        return jnp.concatenate(sheets)[:num]

    def patch(self, heights: Any, x: tuple[float, float], y: tuple[float, float], /) -> Patch:
        """Returns the part of one ground between two corners; it goes on mirrored across."""
        heights = np.asarray(heights)
        first, along = nodes_along(self.start, self.spacing, x, heights.shape[0])
        middle = 0.5 * (heights.shape[1] - 1)
        low = int(np.floor(y[0] / self.spacing + middle))
        rows = np.arange(low, int(np.ceil(y[1] / self.spacing + middle)) + 1)
        period = 2 * (heights.shape[1] - 1)
        across = np.abs(rows - period * np.rint(rows / period)).astype(int)
        return Patch(
            first, self.spacing * (low - middle), self.spacing, heights[np.ix_(along, across)].T
        )

    def height(
        self, terrain: Terrain, x: Float[Array, ""], y: Float[Array, ""] | None = None
    ) -> Float[Array, ""]:
        """Returns the ground's height at (x, y) by bilinear interpolation, m; y is 0 if None."""
        y = jnp.zeros(()) if y is None else y
        edge.check_terrain(terrain, self.num_nodes)
        along, across = self.num_nodes
        period = 2.0 * (across - 1)
        sideways = y / self.spacing + 0.5 * (across - 1)
        sideways = jnp.abs(sideways - period * jnp.round(sideways / period))
        onward = jnp.clip((x - self.start) / self.spacing, 0.0, along - 1)
        # The last interval also serves the end of the grid; NaN becomes node 0.
        row = jnp.minimum(onward.astype(jnp.int32), along - 2)
        column = jnp.minimum(sideways.astype(jnp.int32), across - 2)
        start = (terrain.row, row, column)
        near, far = jax.lax.dynamic_slice(terrain.heights, start, (1, 2, 2))[0]
        ends = near + (onward - row) * (far - near)
        return ends[0] + (sideways - column) * (ends[1] - ends[0])


@functools.partial(jax.jit, static_argnames="across")
def _sheets(
    key: PRNGKeyArray,
    flat: Bool[np.ndarray, " padded"] | Bool[Array, " padded"],
    roughness: float | Float[Array, ""],
    *,
    across: int,
) -> Float[Array, "32 along {across}"]:
    """Returns heights of WORD terrains, level where it is flat.

    Args:
      key: random key, used up.
      flat: which nodes along are; the margins too.
      roughness: the factor r, m.
      across: nodes.
    """
    padded = across + 2 * MARGIN
    key_rows, key_columns = jax.random.split(key)
    layers = serpentine(key_rows, WORD, flat.size, padded)
    layers += serpentine(key_columns, WORD, padded, flat.size).swapaxes(1, 2)
    # Fused with the sums below, the layers would be made anew for each of their terms.
    layers = jax.lax.optimization_barrier(layers)
    edge = jnp.minimum(jnp.sum(flat), flat.size - 1)
    level = layers[:, edge, padded // 2][:, None, None]
    layers = jnp.where(flat[:, None], 0, layers - level)
    smooth = _box_sum(_box_sum(layers, 1), 2).astype(jnp.float32)
    return smooth * (0.5 * roughness / FILTER_SIDE**2)


def serpentine(
    key: PRNGKeyArray, num: int, rows: int, columns: int
) -> Int[Array, "num row column"]:
    """Returns integer grids where every two neighbours differ by one, filled in serpentines.

    A cell is a step of +-1 from the neighbour just filled. Where that neighbour differs from the
    one above by more than one, which is then two, the step cannot lead further away.

    So a cell lies one above or one below the cell over it. Call that side e, and s the slope of
    the row above: from one cell to the next, e stays, or a coin sets it to -s. Either way no two
    neighbours part. Such a chain is a prefix sum, and a bit holds all that it needs: every number
    here stands for 32 grids.
    """
    words = -(-num // WORD)
    coins = jax.random.bits(key, (rows, columns, words))
    first = jnp.cumsum(2 * _unpacked(coins[0], num) - 1, axis=1, dtype=jnp.int16)

    def fill(above: tuple[Array, Array], row: tuple[Array, Array]) -> tuple[Any, Array]:
        heights, rising = above
        coins, backwards = row
        # Back along the row, slopes are turned round. Its first cell may step up or down.
        rising = jnp.concatenate([coins[:1], ~rising[:0:-1]])
        heads = coins.at[0].set(ALL)
        higher, _ = jax.lax.associative_scan(_chained, (heads & ~rising, ~heads))
        rising = rising.at[1:].set(rising[1:] ^ higher[1:] ^ higher[:-1])
        higher = jnp.where(backwards, higher[::-1], higher)
        heights = heights + 2 * _unpacked(higher, num) - 1
        return (heights, rising), heights

    backwards = jnp.arange(1, rows) % 2 == 1
    _, others = jax.lax.scan(fill, (first, coins[0]), (coins[1:], backwards))
    return jnp.concatenate([first[None], others]).swapaxes(0, 1)


def _chained(one: tuple[Array, Array], other: tuple[Array, Array]) -> tuple[Array, Array]:
    """Returns two links of a chain in one; a link is what it sets, and whether it passes on."""
    return other[0] | (other[1] & one[0]), other[1] & one[1]


def _unpacked(words: UInt32[Array, "column word"], num: int) -> Int[Array, "num column"]:
    """Returns the words' bits as numbers."""
    bits = (words.T[:, None, :] >> jnp.arange(WORD, dtype=jnp.uint32)[:, None]) & 1
    return bits.reshape(-1, len(words))[:num].astype(jnp.int16)


def _box_sum(grid: Array, axis: int) -> Array:
    """Returns sums over `FILTER_SIDE` neighbours along an axis, shorter by the margins."""
    size = grid.shape[axis] - 2 * MARGIN
    slices = [jax.lax.slice_in_dim(grid, i, i + size, axis=axis) for i in range(FILTER_SIDE)]
    return sum(slices[1:], slices[0])
