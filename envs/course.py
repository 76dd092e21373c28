"""What lies along a walker's way on top of the random ground: slope, stairs, gaps, and other soil.

ours: the studies that this package follows have random ground alone. All of it is the same at all
y, so that one table of nodes along x holds it: the height that it adds, and where there is other
soil, by what the law of contact is multiplied. Upright edges become slopes of one cell.
"""

import dataclasses
import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.envs import checks, edge
from mjxwalk.envs.contact import Footing
from mjxwalk.envs.course_parts import Gaps, Slope, Stairs, Stretches
from mjxwalk.envs.terrain import Patch, Terrain

HEIGHT, STIFFNESS, FRICTION = 0, 1, 2  # channels of the table; the last two where there is soil


class Underfoot(NamedTuple):
    """What a course is at a place.

    Attributes:
      height: that it adds to the ground, m.
      gradient: m upwards for each m along x; None of a course that is level everywhere.
      footing: other soil; None of a course that has none.
    """

    height: Float[Array, ""]
    gradient: Float[Array, ""] | None
    footing: Footing | None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Course:
    """All that lies along the way; by default, nothing does.

    Attributes:
      slope: up or down.
      stairs: steps up or down.
      gaps: across the way.
      soft: soil whose spring and damper are multiplied by the factor: a layer twice as thick has
        half of both.
      slippery: soil whose coefficient of friction is multiplied by the factor.
      spacing: of the nodes, m; upright edges are slopes that are so long.
      length: of the course, m; beyond, the ground goes on level.
    """

    slope: Slope = Slope()
    stairs: Stairs = Stairs()
    gaps: Gaps = Gaps()
    soft: Stretches = Stretches()
    slippery: Stretches = Stretches()
    # ours: a toe that hits a step at 1 m/s stops in less; of a shorter one it would pass through
    spacing: float = 0.05
    length: float = 102.4  # ours: as of the random grounds

    def __post_init__(self) -> None:
        checks.positive(self, "spacing", "length")
        checks.nodes(self, "length")
        if self.length < 2 * self.spacing:
            raise ValueError(f"length must hold two nodes, got {self.length} m")
        least = 2 * self.spacing
        for part, name in (
            (self.stairs, "tread"),
            (self.gaps, "width"),
            (self.soft, "width"),
            (self.slippery, "width"),
        ):
            if part and getattr(part, name) < least:
                raise ValueError(
                    f"the {name} of {type(part).__name__} must be two spacings, {least:g} m, at "
                    f"least, got {getattr(part, name)} m; make spacing smaller"
                )

    @property
    def has_relief(self) -> bool:
        """Whether it is not level."""
        return bool(self.slope or self.stairs or self.gaps)

    @property
    def has_soil(self) -> bool:
        """Whether there is other soil."""
        return bool(self.soft or self.slippery)

    @property
    def num_nodes(self) -> int:
        """Nodes of one course; the first lies at x = 0."""
        return round(self.length / self.spacing)

    @property
    def num_channels(self) -> int:
        """Numbers at each node; 0 where nothing lies along the way."""
        if self.has_soil:
            return 3
        return 1 if self.has_relief else 0

    def words(self) -> str:
        """Returns what lies along the way in a few words, "" where nothing does."""
        slope, stairs = self.slope, self.stairs
        told = [
            (slope, f"slope {checks.span(100 * slope.gradient, 100 * slope.spread)} %"),
            (stairs, f"steps {checks.span(1000 * stairs.rise, 1000 * stairs.spread)} mm"),
            (self.gaps, f"gaps {1000 * self.gaps.width:g} mm"),
            (self.soft, f"stiffness {self.soft.factor:g} in stretches"),
            (self.slippery, f"friction {self.slippery.factor:g} in stretches"),
        ]
        return ", ".join(text for part, text in told if part)

    def sample(self, key: PRNGKeyArray, num: int) -> Float[Array, "trial node channel"] | None:
        """Returns `num` independent courses; None where nothing lies along the way."""
        return _sample(self, key, num) if self.num_channels else None

    def under(self, terrain: Terrain, x: Float[Array, ""]) -> Underfoot | None:
        """Returns what lies at x by linear interpolation; None for a trial without a course."""
        if terrain.course is None:
            return None
        edge.check_course(terrain, (self.num_nodes, self.num_channels))
        last = self.num_nodes - 1
        position = jnp.clip(x / self.spacing, 0.0, last)
        # The last interval also serves x beyond the end; NaN becomes node 0.
        node = jnp.minimum(position.astype(jnp.int32), last - 1)
        start, size = (terrain.row, node, np.int32(0)), (1, 2, self.num_channels)
        near, far = jax.lax.dynamic_slice(terrain.course, start, size)[0]
        values = near + (position - node) * (far - near)
        gradient, footing = None, None
        if self.has_relief:
            inside = (x > 0.0) & (x < last * self.spacing)
            gradient = jnp.where(inside, (far[HEIGHT] - near[HEIGHT]) / self.spacing, 0.0)
        if self.has_soil:
            footing = Footing(values[STIFFNESS], values[FRICTION])
        return Underfoot(values[HEIGHT], gradient, footing)

    def on(self, patch: Patch, course: Float[np.ndarray, "node channel"] | None) -> Patch:
        """Returns a part of the random ground with a course on it; its nodes may be closer."""
        if course is None or not self.has_relief:
            return patch
        spacing = min(patch.spacing, self.spacing)
        rows, columns = patch.heights.shape
        coarse, fine = (_places(columns, patch.spacing, each) for each in (patch.spacing, spacing))
        heights = np.stack([np.interp(fine, coarse, row) for row in patch.heights])
        if rows > 1:
            wide, across = (_places(rows, patch.spacing, each) for each in (patch.spacing, spacing))
            heights = np.stack([np.interp(across, wide, column) for column in heights.T], axis=1)
        nodes = self.spacing * np.arange(self.num_nodes)
        lying = np.interp(patch.x + fine, nodes, course[:, HEIGHT])
        return patch._replace(spacing=spacing, heights=heights + lying)


def _places(num: int, spacing: float, finer: float) -> Float[np.ndarray, " node"]:
    """Returns nodes of a finer spacing along the length of so many nodes, m from the first."""
    return finer * np.arange(int((num - 1) * spacing / finer + 1e-6) + 1)


@functools.partial(jax.jit, static_argnums=(0, 2))
def _sample(course: Course, key: PRNGKeyArray, num: int) -> Float[Array, "trial node channel"]:
    keys = jax.random.split(key, 5)
    x = course.spacing * np.arange(course.num_nodes)
    relief = (course.slope, course.stairs, course.gaps)
    level = jnp.zeros((num, x.size))
    height = sum(
        (part.sample(each, num, x) for part, each in zip(relief, keys, strict=False) if part), level
    )
    channels = [height]
    if course.has_soil:
        channels += [course.soft.sample(keys[3], num, x), course.slippery.sample(keys[4], num, x)]
    return jnp.stack(channels, axis=-1).astype(jnp.float32)
