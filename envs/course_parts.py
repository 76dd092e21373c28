"""Parts of a course, with their settings and how trials draw them: slope, stairs, gaps, stretches.

Each draws a row of nodes along x for each trial; the first node lies at x = 0. Edges are rounded to
nodes, so that what is 0.3 m long is so in every trial.
"""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from mjxwalk.envs import checks

BEGIN = 2.0  # m; ours: a step or two on level ground come first


@dataclasses.dataclass(frozen=True, kw_only=True)
class Slope:
    """A slope that goes on to the end of the course.

    Attributes:
      gradient: m upwards for each m along x; negative is downhill, 0 is none.
      spread: largest deviation from it that a trial draws, to either side.
      begin: where it begins, m.
    """

    gradient: float = 0.0
    spread: float = 0.0
    begin: float = BEGIN

    def __post_init__(self) -> None:
        checks.finite(self, "gradient")
        checks.not_negative(self, "spread", "begin")

    def __bool__(self) -> bool:
        return bool(self.gradient or self.spread)

    def sample(
        self, key: PRNGKeyArray, num: int, x: Float[np.ndarray, " node"]
    ) -> Float[Array, "{num} node"]:
        """Returns the heights of `num` trials, m."""
        along = np.maximum(0.0, x - self.begin).astype(np.float32)
        return _drawn(self.gradient, self.spread, key, num) * along


@dataclasses.dataclass(frozen=True, kw_only=True)
class Stairs:
    """Steps of equal height; beyond the last one it goes on level.

    Attributes:
      rise: of each step, m; negative is downwards, 0 is none.
      spread: largest deviation from it that a trial draws, to either side, m.
      tread: from one step to the next, m.
      number: of steps.
      begin: where the first one is, m.
    """

    rise: float = 0.0
    spread: float = 0.0
    tread: float = 0.3  # ours: a usual one
    number: int = 10
    begin: float = BEGIN

    def __post_init__(self) -> None:
        checks.finite(self, "rise")
        checks.not_negative(self, "spread", "begin")
        checks.positive(self, "tread")
        checks.count(self, "number")

    def __bool__(self) -> bool:
        return bool(self.rise or self.spread)

    def sample(
        self, key: PRNGKeyArray, num: int, x: Float[np.ndarray, " node"]
    ) -> Float[Array, "{num} node"]:
        """Returns the heights of `num` trials, m; an edge rises behind its node."""
        number = min(self.number, int(x[-1] / self.tread) + 1)  # that there is room for
        edges = self.begin + self.tread * np.arange(number)
        steps = np.searchsorted(_node_of(edges, x), np.arange(x.size)).astype(np.float32)
        return _drawn(self.rise, self.spread, key, num) * steps


@dataclasses.dataclass(frozen=True, kw_only=True)
class Stretches:
    """Stretches of other soil, one in each piece of the way.

    Attributes:
      factor: by which the soil differs there; 1 is not at all.
      width: of each stretch along x, m.
      every: length of a piece, m; without a spread the stretch is in its middle.
      spread: largest distance from there that a trial draws, to either side, m.
      begin: where the first piece begins, m.
    """

    factor: float = 1.0
    width: float = 1.0
    every: float = 3.0
    spread: float = 1.0
    begin: float = BEGIN

    def __post_init__(self) -> None:
        checks.positive(self, "factor", "width", "every")
        checks.not_negative(self, "spread", "begin")
        _check_room(self)

    def __bool__(self) -> bool:
        return self.factor != 1.0

    def sample(
        self, key: PRNGKeyArray, num: int, x: Float[np.ndarray, " node"]
    ) -> Float[Array, "{num} node"]:
        """Returns the factors of `num` trials."""
        return jnp.where(_inside(self, key, num, x), self.factor, 1.0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Gaps:
    """Gaps across the way, one in each piece of it.

    Attributes:
      width: of each gap from edge to edge, m; 0 is none.
      depth: of each gap, m.
      every: length of a piece, m; without a spread the gap is in its middle.
      spread: largest distance from there that a trial draws, to either side, m.
      begin: where the first piece begins, m.
    """

    width: float = 0.0
    depth: float = 0.5  # ours: who steps in has fallen
    every: float = 2.0
    spread: float = 0.5
    begin: float = BEGIN

    def __post_init__(self) -> None:
        checks.not_negative(self, "width", "depth", "spread", "begin")
        checks.positive(self, "every")
        _check_room(self)

    def __bool__(self) -> bool:
        return bool(self.width and self.depth)

    def sample(
        self, key: PRNGKeyArray, num: int, x: Float[np.ndarray, " node"]
    ) -> Float[Array, "{num} node"]:
        """Returns the heights of `num` trials, m: minus the depth in gaps, else 0."""
        return jnp.where(_inside(self, key, num, x), -self.depth, 0.0)


def _check_room(settings: Gaps | Stretches) -> None:
    """Raises ValueError unless each lies in its own piece of the way, wherever it is drawn."""
    least = settings.width + 2.0 * settings.spread
    if settings.every < least:
        raise ValueError(
            f"every must be width and twice the spread at least, {least:g} m, got "
            f"{settings.every} m"
        )


def _drawn(mean: float, spread: float, key: PRNGKeyArray, num: int) -> Float[Array, "{num} 1"]:
    return mean + spread * jax.random.uniform(key, (num, 1), minval=-1.0, maxval=1.0)


def _node_of(place: Float[np.ndarray, " edge"], x: Float[np.ndarray, " node"]) -> np.ndarray:
    """Returns the nodes that are nearest to places, counted on beyond the last."""
    return np.rint(place / x[1])


def _inside(
    parts: Gaps | Stretches, key: PRNGKeyArray, num: int, x: Float[np.ndarray, " node"]
) -> Bool[Array, "{num} node"]:
    """Returns which nodes of `num` trials lie within gaps or stretches."""
    piece = np.floor((x - parts.begin) / parts.every).astype(int)
    pieces = max(int(piece[-1]) + 1, 1)
    draws = jax.random.uniform(key, (num, pieces), minval=-1.0, maxval=1.0)
    middle = parts.begin + parts.every * (np.arange(pieces, dtype=np.float32) + 0.5)
    first = jnp.round((middle + parts.spread * draws - 0.5 * parts.width) / x[1])
    since = np.arange(x.size) - first[:, np.maximum(piece, 0)]
    return (piece >= 0) & (since > 0) & (since < round(parts.width / x[1]))
