"""Joint angles over one gait cycle, and their Fourier series."""

import dataclasses
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

NUM_POINTS = 100  # of a cycle; the next is the first again
Curve = Float[np.ndarray, "100"]


# Not compared: arrays have no single truth.
@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Gait:
    """Angles of one leg from heel strike to heel strike, in percent; flexion is positive.

    Attributes:
      name: where they are from.
      hip: degrees.
      knee: degrees.
      ankle: degrees, dorsiflexion positive; None where nobody measured it.
      stride_time: of the cycle, s; None where the source has no time.
    """

    name: str
    hip: Curve
    knee: Curve
    ankle: Curve | None = None
    stride_time: float | None = None

    def __post_init__(self) -> None:
        for name in ("hip", "knee", "ankle"):
            value: Any = getattr(self, name)
            if value is not None and value.shape != (NUM_POINTS,):
                raise ValueError(f"{name} must have shape ({NUM_POINTS},), got {value.shape}")
        if self.stride_time is not None and not self.stride_time > 0:
            raise ValueError(f"stride_time must be positive, got {self.stride_time}")

    @property
    def four_joints(self) -> Float[np.ndarray, "100 4"]:
        """Left hip, right hip, left knee and right knee; the right leg is half a cycle off."""
        half = NUM_POINTS // 2
        legs = [self.hip, np.roll(self.hip, half), self.knee, np.roll(self.knee, half)]
        return np.stack(legs, axis=1)


class Harmonics(NamedTuple):
    """A Fourier series: mean + sum_h cosine_h cos(h x) + sine_h sin(h x).

    Attributes:
      mean: degrees.
      cosine: degrees, of harmonic 1 first.
      sine: degrees.
    """

    mean: float
    cosine: Float[np.ndarray, " harmonic"]
    sine: Float[np.ndarray, " harmonic"]

    @property
    def amplitude(self) -> Float[np.ndarray, " harmonic"]:
        """Degrees."""
        return np.hypot(self.cosine, self.sine)

    @property
    def phase(self) -> Float[np.ndarray, " harmonic"]:
        """Such that harmonic h is amplitude cos(h x + phase), rad."""
        return np.arctan2(-self.sine, self.cosine)


def harmonics(curve: Float[np.ndarray, " point"], num: int) -> Harmonics:
    """Returns the first harmonics of one cycle of evenly spaced points.

    Raises:
      ValueError: the points cannot tell so many.
    """
    most = (len(curve) - 1) // 2
    if not 1 <= num <= most:
        raise ValueError(f"num must be from 1 to {most}, got {num}")
    series = np.fft.rfft(curve) * (2.0 / len(curve))
    return Harmonics(
        mean=float(series[0].real) / 2,
        cosine=series[1 : num + 1].real,
        sine=-series[1 : num + 1].imag,
    )


def evaluate(
    series: Harmonics, phase: Float[np.ndarray, " point"], derivative: int = 0
) -> Float[np.ndarray, " point"]:
    """Returns a Fourier series, or a derivative of it by the phase, at some phases (rad)."""
    order = np.arange(1, len(series.cosine) + 1)
    # Each derivative leads by a quarter of a turn and brings down the harmonic's number.
    at = np.outer(phase, order) + derivative * np.pi / 2
    rows = order**derivative * (series.cosine * np.cos(at) + series.sine * np.sin(at))
    return rows.sum(axis=1) + (series.mean if derivative == 0 else 0.0)
