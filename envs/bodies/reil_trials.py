"""How the trials of the biped of Reil & Massey differ: starts, loads and slopes.

Ours: the paper has one start, one body and flat ground. A gait that evolves under one of each may
hold only there, so that a trial can draw its own.
"""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.envs import checks, edge
from mjxwalk.envs.terrain import Patch, Terrain
from mjxwalk.envs.trial import Trials

STARTS = ("push", "sideways", "pitch_rate", "stride")
NAMES = (*STARTS, "load", "slope")


@dataclasses.dataclass(frozen=True, kw_only=True)
class TrialVariation:
    """Flat ground, and how far a trial may be from the usual one, to either side.

    All between is equally likely; with zeros every trial is the paper's.

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

    @property
    def num_nodes(self) -> int:
        """One: a plane's heights are that at x = 1 m."""
        return 1

    def sample_trials(self, key: PRNGKeyArray, num: int) -> Trials:
        """Returns `num` independent trials."""
        return self.drawn(jax.random.uniform(key, (num, len(NAMES)), minval=-1.0, maxval=1.0))

    def drawn(self, draws: Float[Array, "trial 6"]) -> Trials:
        """Returns the trials of draws from -1 to 1, a column for each of `NAMES`."""
        num = len(STARTS)
        load, slope = draws[:, num], draws[:, num + 1]
        return Trials(self.slope * slope[:, None], draws[:, :num], load)

    def departures(
        self, start: Float[Array, " departure"] | None
    ) -> tuple[Float[Array, ""], Float[Array, ""], Float[Array, ""], Float[Array, ""]]:
        """Returns push and sideways, m/s, pitch rate, rad/s, and stride, rad, of a start."""
        draws = jnp.zeros(len(STARTS)) if start is None else start
        push, sideways, pitch_rate, stride = (
            getattr(self, name) * draws[place] for place, name in enumerate(STARTS)
        )
        return push, sideways, pitch_rate, stride

    def patch(self, heights: Any, x: tuple[float, float], y: tuple[float, float], /) -> Patch:
        """Returns a plane that rises along x."""
        del y
        along = np.arange(np.floor(x[0]), np.ceil(x[1]) + 1)
        return Patch(float(along[0]), 0.0, 1.0, (float(heights[0]) * along)[None])

    def height(
        self, terrain: Terrain, x: Float[Array, ""], y: Float[Array, ""] | None = None
    ) -> Float[Array, ""]:
        """Returns the ground's height at x, m; it is the same at all y."""
        del y
        edge.check_terrain(terrain, (1,))
        if not self.slope:
            return jnp.zeros(())
        return jax.lax.dynamic_slice_in_dim(terrain.heights, terrain.row, 1)[0, 0] * x

    def is_usual(self) -> bool:
        """Returns whether all trials are the same."""
        return not any(getattr(self, name) for name in NAMES)


def usual(num: int = 1) -> Trials:
    """Returns trials that differ in nothing."""
    return TrialVariation().drawn(jnp.zeros((num, len(NAMES))))
