"""Timing of contenders in turn, so that a machine that drifts hits all of them alike."""

import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

Contender = Callable[[int], int]
"""Does an amount of work, in its own unit, and returns how much was done, in the common one."""

Clock = Callable[[], float]
FASTER = 8  # ours: amounts grow by at most this factor, as the first timings hardly tell


class Timing(NamedTuple):
    """One repeat: what was done, and in how many seconds."""

    work: int
    seconds: float


def calibrate(contender: Contender, seconds: float, clock: Clock = time.perf_counter) -> int:
    """Returns the amount that keeps a contender busy for about that long.

    The first call, which compiles, is not timed.
    """
    amount = 1
    contender(amount)
    while True:
        taken = max(_timed(contender, amount, clock).seconds, 1e-9)
        if taken > 0.25 * seconds:
            return max(1, round(amount * seconds / taken))
        amount = max(amount + 1, round(amount * min(FASTER, seconds / taken)))


def in_turn(
    contenders: Mapping[str, Contender],
    amounts: Mapping[str, int],
    repeats: int,
    clock: Clock = time.perf_counter,
) -> dict[str, list[Timing]]:
    """Returns the timings of each contender, who take turns: A B A B."""
    timings: dict[str, list[Timing]] = {name: [] for name in contenders}
    for _ in range(repeats):
        for name, contender in contenders.items():
            timings[name].append(_timed(contender, amounts[name], clock))
    return timings


def rate(timings: Sequence[Timing]) -> float:
    """Returns the median work a second."""
    return statistics.median(timing.work / timing.seconds for timing in timings)


def ratio(timings: Sequence[Timing], others: Sequence[Timing]) -> float:
    """Returns how many times as fast: the median over timings that followed on each other."""
    pairs = zip(timings, others, strict=True)
    return statistics.median(
        (ours.work / ours.seconds) / (theirs.work / theirs.seconds) for ours, theirs in pairs
    )


def _timed(contender: Contender, amount: int, clock: Clock) -> Timing:
    started = clock()
    work = contender(amount)
    return Timing(work, clock() - started)
