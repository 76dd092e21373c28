"""Cuts one walker's trial into strides, from when and where its feet touch the ground.

A stride goes from one touch-down of a foot to its next, with one of the other foot in between. What
is measured is the same for every body with two feet; plain numpy.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

# s; ours: feet bounce when they touch down, scuff when they swing and tremble when they leave, all
# shorter than this; stance and swing of a gait last at least three times as long.
SHORTEST_PHASE = 0.05


class Strides(NamedTuple):
    """One stride a row, in the order in which they end.

    Attributes:
      foot: whose touch-downs begin and end it; 0 is the left, 1 the right.
      start: s.
      end: s.
      length: from where the foot touched down to where it does again, m, forward.
      step_length: from where the other foot touched down in between to where this one does, m.
      double_stance: share of the stride in which both feet are on the ground.
      swing_time: during which the foot is in the air, s.
    """

    foot: Int[np.ndarray, " stride"]
    start: Float[np.ndarray, " stride"]
    end: Float[np.ndarray, " stride"]
    length: Float[np.ndarray, " stride"]
    step_length: Float[np.ndarray, " stride"]
    double_stance: Float[np.ndarray, " stride"]
    swing_time: Float[np.ndarray, " stride"]

    @property
    def duration(self) -> Float[np.ndarray, " stride"]:
        """Time that each takes, s."""
        return self.end - self.start

    @property
    def speed(self) -> Float[np.ndarray, " stride"]:
        """Length over duration, m/s."""
        return self.length / self.duration


def no_strides() -> Strides:
    """Returns the strides of a walker that takes none."""
    return find_strides(np.zeros(0), np.zeros((0, 2), bool), np.zeros((0, 2)))


def find_strides(
    time: Float[np.ndarray, " frame"],
    contact: Bool[np.ndarray, "frame 2"],
    ankle_x: Float[np.ndarray, "frame 2"],
) -> Strides:
    """Returns the whole strides of a trial, none of a walker that stands still.

    A stride in which the other foot touches down never or twice, as in a stumble, is none.

    Args:
      time: s, strictly rising: without the frames after the trial's end.
      contact: whether each foot touches the ground, without chatter: see `debounced`.
      ankle_x: where each ankle is, m.
    """
    downs = [_touch_downs(contact[:, foot]) for foot in (0, 1)]
    both: Any = contact.all(axis=1)
    rows: list[tuple[Any, ...]] = []
    for foot in (0, 1):
        for start, end in zip(downs[foot][:-1], downs[foot][1:], strict=True):
            between = downs[1 - foot][(downs[1 - foot] > start) & (downs[1 - foot] < end)]
            if between.size != 1:
                continue
            lands = ankle_x[end, foot]
            period = time[end] - time[start]
            # A frame stands for the time up to the next one.
            frames = np.diff(time[start : end + 1])
            rows.append(
                (
                    foot,
                    time[start],
                    time[end],
                    lands - ankle_x[start, foot],
                    lands - ankle_x[between[0], 1 - foot],
                    float(frames[both[start:end]].sum() / period),
                    float(frames[~contact[start:end, foot]].sum()),
                )
            )
    rows.sort(key=lambda row: row[2])
    columns = np.array(rows, np.float64).reshape(-1, len(Strides._fields)).T
    return Strides(columns[0].astype(np.int64), *columns[1:])


def debounced(
    contact: Bool[np.ndarray, "frame foot"],
    time: Float[np.ndarray, " frame"],
    shortest: float = SHORTEST_PHASE,
) -> Bool[np.ndarray, "frame foot"]:
    """Returns contacts without phases that are too short to belong to a gait.

    First, gaps between touches are closed, so that a foot that bounces touches down at its first
    touch, and one that drags along the ground touches it; then touches that are still short are
    taken out. What lasts too short at the end, where nobody knows how it goes on, counts as what
    came before.

    Args:
      contact: whether each foot touches the ground.
      time: s.
      shortest: phase that stays, s.
    """
    columns = [contact[:, foot].copy() for foot in range(contact.shape[1])]
    for column in columns:
        for kind in (False, True):
            _drop_short(column, time, kind, shortest)
    return np.stack(columns, axis=1)


def stance_leg(
    contact: Bool[np.ndarray, "frame 2"], ankle_x: Float[np.ndarray, "frame 2"]
) -> Bool[np.ndarray, " frame"]:
    """Returns whether the left leg is the stance leg, by the rule of the paper's section 2.4.

    The leg on the ground is; of two, the trailing one; in flight, the one that was. Before all
    contact it is the right one, as `mjxwalk.controllers.linear_reactive` has it.

    Args:
      contact: whether each foot touches the ground.
      ankle_x: where each ankle is, m, from any origin.
    """
    left, right = contact[:, 0], contact[:, 1]
    known = left | right
    stance = np.where(left & right, ankle_x[:, 0] < ankle_x[:, 1], left)
    latest = np.maximum.accumulate(np.where(known, np.arange(len(known)), -1))
    return np.where(latest >= 0, stance[latest], False)


def role_periods(
    left_stance: Bool[np.ndarray, " frame"],
) -> Int[np.ndarray, "period 2"]:
    """Returns frames from and before which one leg is the stance leg; whole periods only.

    The first and the last period of a trial are no whole ones.
    """
    changes = 1 + np.flatnonzero(left_stance[1:] != left_stance[:-1])
    return np.stack([changes[:-1], changes[1:]], axis=1)


def _touch_downs(contact: Bool[np.ndarray, " frame"]) -> Int[np.ndarray, " touch"]:
    return 1 + np.flatnonzero(contact[1:] & ~contact[:-1])


def _drop_short(
    contact: Bool[np.ndarray, " frame"], time: Float[np.ndarray, " frame"], kind: bool, least: float
) -> None:
    """Turns phases of a kind that are too short into their surroundings, in place."""
    if not len(contact):
        return
    edges = np.concatenate([[0], 1 + np.flatnonzero(np.diff(contact)), [len(contact)]])
    ends = np.append(time, time[-1])
    for start, end in zip(edges[:-1], edges[1:], strict=True):
        # Rounding must not decide over a phase of exactly so many frames.
        if start > 0 and contact[start] == kind and ends[end] - ends[start] < least - 1e-6:
            contact[start:end] = not kind
