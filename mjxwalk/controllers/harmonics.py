"""A generator for any body: each joint swings by a few harmonics of one clock, and feels nothing.

Joints of a gait are periodic, so that a short Fourier series says all of them; see the harmonic
oscillators of `mjxwalk.controllers.rayleigh` for the same as differential equations.
"""

import dataclasses
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.controllers.controller import Description
from mjxwalk.controllers.policy import Policy
from mjxwalk.controllers.wiring import Connection, Wiring, ends, units
from mjxwalk.envs.checks import count


class Swing(NamedTuple):
    """A genotype.

    Attributes:
      sines: of each row, by harmonics.
      cosines: of the same.
      centre: of each row.
      pace: gene of the clock's frequency.
    """

    sines: Float[Array, "row harmonic"]
    cosines: Float[Array, "row harmonic"]
    centre: Float[Array, " row"]
    pace: Float[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Harmonics(Policy):
    """A short Fourier series for each motor.

    Attributes:
      harmonics: how many; the first has the clock's frequency.
    """

    harmonics: int = 3

    def __post_init__(self) -> None:
        count(self, "harmonics")
        super().__post_init__()

    def weights(self) -> Swing:
        """Returns a walker that lifts its legs in turn: the series of half a sine."""
        lift = np.array(self.lift, np.float32)[:, None]
        order = np.arange(1, self.harmonics + 1)
        # A half sine is 1/pi + sin/2 - 2/pi sum of cos(2 k phase) / (4 k^2 - 1).
        even = np.where(order % 2 == 0, -2.0 / np.pi / (order**2 - 1.0 + (order == 1)), 0.0)
        sines = lift * np.where(order == 1, 0.5, 0.0)
        return Swing(
            jnp.asarray(sines, jnp.float32),
            jnp.asarray(lift * even, jnp.float32),
            jnp.asarray(lift[:, 0] / np.pi),
            jnp.zeros(()),
        )

    @property
    def sees_clock(self) -> bool:
        """Whether it sees a clock: nothing else."""
        return True

    def wiring(self) -> Wiring:
        """Returns the motors, which read harmonics; sine and cosine of one are one link."""
        _, motors = ends(self.describe())
        waves = units("clock", "harmonic", self.harmonics)
        parts = [Connection(leaf, "clock", "motors") for leaf in ("sines", "cosines")]
        return Wiring((waves, motors), tuple(parts))

    def describe(self) -> Description:
        """Returns the rows of the series, which read no senses."""
        return super().describe()._replace(inputs=())

    def respond(
        self,
        genotype: Swing,
        memory: Any,
        seen: Float[Array, "side input"],
        phase: Float[Array, " side"],
        /,
    ) -> tuple[Any, Float[Array, "side row"]]:
        """Returns no memory, and the series at the clock's phase."""
        del seen
        angles = phase[:, None] * np.arange(1, self.harmonics + 1, dtype=np.float32)
        swing = jnp.sin(angles) @ genotype.sines.T + jnp.cos(angles) @ genotype.cosines.T
        return memory, swing + genotype.centre
