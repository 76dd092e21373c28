"""Figures of what walkers did in their trials."""

from typing import Any

import numpy as np
from jaxtyping import Float


def over_terrains(values: Any) -> Float[np.ndarray, " pop"]:
    """Returns each genotype's mean of values [pop, terrain]; NaN if one of its values is."""
    return np.asarray(np.mean(values, axis=1, dtype=np.float64), np.float32)


def speed(distance: Any, duration: Any) -> float | None:
    """Returns the distance of all trials over their duration, m/s; None if they had none."""
    total = float(np.sum(duration, dtype=np.float64))
    return float(np.sum(distance, dtype=np.float64)) / total if total > 0 else None


def cost_of_transport(work: Any, distance: Any, weight: float) -> float | None:
    """Returns the work (J) of all trials over weight (N) times distance (m), without unit.

    None of walkers that did not get forward, or whose figures are not finite.
    """
    total = float(np.sum(distance, dtype=np.float64))
    cost = float(np.sum(work, dtype=np.float64)) / (weight * total) if total > 0 else np.nan
    return float(cost) if np.isfinite(cost) else None
