"""Angles by role over a step: how often a walker passes through each, and the average course.

Figures 6 and 8 of Solomon, Locascio & Hartmann (2013), Adaptive Behavior 21(1), doi
10.1177/1059712312462904, sections 3.4 and 3.5. A step
here goes from one change of roles to the next: the foot behind lifts off, its leg swings, and
touches down; it ends as the other foot lifts off. The paper calls it a stride, since to networks
that belong to roles each step is a whole cycle.
"""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from mjxwalk.analysis.footfalls import find_footfalls, observe, role_angles
from mjxwalk.analysis.roles import PLANAR, Roles, roles_of
from mjxwalk.analysis.strides import role_periods
from mjxwalk.envs import LeggedEnv
from mjxwalk.replay import Recording

SLICES = 100  # of a step's time; ours
BINS = 240  # of an angle's range; ours
SETTLED = 3.0  # s; ours: gait initiation is over, and a few steps more
SHORTEST_STEP = 0.15  # s; ours: a change of roles and back, as in a stumble, is no step


class AngleDensity(NamedTuple):
    """How often each angle was where, in each slice of the step.

    Attributes:
      names: of the angles.
      edges: of the bins of each angle, degrees.
      counts: of steps; what is outside the edges is missing.
      sums: of each angle, degrees.
      steps: number of them.
    """

    names: tuple[str, ...]
    edges: Float[np.ndarray, "angle edge"]
    counts: Int[np.ndarray, "angle slice bin"]
    sums: Float[np.ndarray, "angle slice"]
    steps: int

    @property
    def mean(self) -> Float[np.ndarray, "angle slice"]:
        """The average course of each angle, degrees; NaN without steps."""
        return self.sums / self.steps if self.steps else np.full(self.sums.shape, np.nan)

    @property
    def whiteness(self) -> Float[np.ndarray, "angle slice bin"]:
        """Counts as shares of the most frequent state of the same slice, as in the paper."""
        most = self.counts.max(axis=2, keepdims=True)
        return self.counts / np.maximum(most, 1)


def step_angles(
    recording: Recording, env: LeggedEnv, *, slices: int = SLICES, settled: float = SETTLED
) -> Float[np.ndarray, "step slice angle"]:
    """Returns the angles by role over every step of the trials without a fall, degrees.

    Args:
      recording: of trials from their start.
      env: that they are trials of.
      slices: of equal time that each step is cut into; angles are those in their middles.
      settled: steps that begin earlier do not count, s.

    Raises:
      ValueError: the body has no angles by role.
    """
    observations = observe(recording, env)
    footfalls = find_footfalls(recording, observations)
    roles = _roles(env)
    angles = np.degrees(role_angles(observations, footfalls, roles.sense).astype(np.float64))
    found: list[Any] = []
    for walker in np.flatnonzero(~recording.states.trial.fell[-1]):
        time = footfalls[walker].time
        for first, last in role_periods(footfalls[walker].left_stance):
            period = time[last] - time[first]
            if time[first] < settled or period < SHORTEST_STEP:
                continue
            middles = time[first] + period * (np.arange(slices) + 0.5) / slices
            # The frame at which roles have changed is already the next step's.
            frames = slice(first, last)
            columns = angles[frames, walker].T
            found.append(np.stack([np.interp(middles, time[frames], c) for c in columns], 1))
    return np.array(found, np.float64).reshape(-1, slices, angles.shape[2])


def empty_density(roles: Roles = PLANAR, *, slices: int = SLICES, bins: int = BINS) -> AngleDensity:
    """Returns the density of no steps, over the usual ranges."""
    edges = np.stack([np.linspace(low, high, bins + 1) for low, high in roles.ranges])
    counts = np.zeros((len(roles.names), slices, bins), np.int64)
    return AngleDensity(roles.names, edges, counts, np.zeros(counts.shape[:2]), 0)


def add_steps(density: AngleDensity, angles: Float[np.ndarray, "step slice angle"]) -> AngleDensity:
    """Returns the density with steps added, so that many trials need not be held at once."""
    counts = density.counts.copy()
    places = np.arange(counts.shape[1])
    for angle, edges in enumerate(density.edges):
        bins = np.searchsorted(edges, angles[:, :, angle], side="right") - 1
        inside = (bins >= 0) & (bins < counts.shape[2])
        rows = np.broadcast_to(places, bins.shape)
        np.add.at(counts[angle], (rows[inside], bins[inside]), 1)
    return density._replace(
        counts=counts,
        sums=density.sums + angles.sum(axis=0).T,
        steps=density.steps + len(angles),
    )


def angle_density(recordings: Iterable[Recording], env: LeggedEnv) -> AngleDensity:
    """Returns the density of the angles over all steps of trials without a fall.

    Args:
      recordings: of trials from their start; one at a time is held.
      env: that they are trials of.
    """
    density = empty_density(_roles(env))
    for recording in recordings:
        density = add_steps(density, step_angles(recording, env))
    return density


def _roles(env: LeggedEnv) -> Roles:
    roles = roles_of(env)
    if roles is None:
        raise ValueError(
            f"{env.anatomy.name} has no angles by role: it needs two feet, and of each leg the "
            "hip, the knee and the ankle"
        )
    return roles
