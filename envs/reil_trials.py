"""How the trials of the biped of Reil & Massey differ: starts, loads and slopes.

Ours: the paper has one start, one body and flat ground. A gait that evolves under one of each may
hold only there, so that a trial can draw its own.
"""

import dataclasses

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.envs import checks, edge
from mjxwalk.envs.terrain import Terrain

NAMES = ("push", "sideways", "pitch_rate", "stride", "load", "slope")


@dataclasses.dataclass(frozen=True, kw_only=True)
class TrialVariation:
    """Flat ground, and how far a trial may be from the usual one, to either side.

    All between is equally likely; with zeros every trial is the paper's. What is drawn is a row of
    the `Terrain` table, each number from -1 to 1.

    Attributes:
      push: of the hips forward, m/s; the body turns about its ankles with it.
      sideways: of the hips to the left, m/s; the body tips about its feet with it.
      pitch_rate: of the trunk, rad/s; the thighs keep theirs.
      stride: angle of the left leg ahead of the vertical, of the right one behind, rad.
      load: carried at the trunk's centre, kg; a negative one makes the trunk lighter.
      slope: of the ground along x, uphill positive.
    """

    push: float = 0.0
    sideways: float = 0.0
    pitch_rate: float = 0.0
    stride: float = 0.0
    load: float = 0.0
    slope: float = 0.0

    def __post_init__(self) -> None:
        checks.not_negative(self, *NAMES)

    @property
    def roughness(self) -> float:
        """Zero: the ground is a plane, m."""
        return 0.0

    def sample(self, key: PRNGKeyArray, num: int) -> Float[Array, "{num} 6"]:
        """Returns what is drawn for `num` independent trials."""
        return jax.random.uniform(key, (num, len(NAMES)), minval=-1.0, maxval=1.0)

    def drawn(self, terrain: Terrain, name: str) -> Float[Array, ""]:
        """Returns how far a trial is from the usual one in what the field of that name says."""
        edge.check_terrain(terrain, (len(NAMES),))
        place = (terrain.row, NAMES.index(name))
        return getattr(self, name) * jax.lax.dynamic_slice(terrain.heights, place, (1, 1))[0, 0]

    def height(
        self, terrain: Terrain, x: Float[Array, ""], y: Float[Array, ""] | None = None
    ) -> Float[Array, ""]:
        """Returns the ground's height at x, m; it is the same at all y."""
        del y
        return self.drawn(terrain, "slope") * x

    def is_usual(self) -> bool:
        """Returns whether all trials are the same."""
        return not any(getattr(self, name) for name in NAMES)


def usual(num: int = 1) -> Float[Array, "{num} 6"]:
    """Returns the rows of trials that differ in nothing."""
    return jnp.zeros((num, len(NAMES)))
