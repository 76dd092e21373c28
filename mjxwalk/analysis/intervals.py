"""How far a share that was counted in so many trials may be from the true one."""

import math
from typing import NamedTuple

NORMAL_QUANTILE = 1.959963984540054  # of 97.5 %: leaves 5 % outside, on both sides together


class Interval(NamedTuple):
    """Both ends of a 95 % interval."""

    low: float
    high: float


def wilson(successes: int, trials: int) -> Interval:
    """Returns the score interval of a share.

    Wilson (1927), "Probable inference, the law of succession, and statistical inference", Journal
    of the American Statistical Association 22, 209-212. It stays within 0 and 1, and is no point
    where nobody or everybody succeeded.

    Raises:
      ValueError: there was no trial, or there were not as many successes.
    """
    if trials < 1:
        raise ValueError(f"trials must be at least 1, got {trials}")
    if not 0 <= successes <= trials:
        raise ValueError(f"successes must be from 0 to {trials}, got {successes}")
    share = successes / trials
    square = NORMAL_QUANTILE**2
    spread = NORMAL_QUANTILE * math.sqrt(
        share * (1 - share) / trials + square / (4 * trials * trials)
    )
    centre, scale = share + square / (2 * trials), 1 + square / trials
    # Rounding must not leave a hair beside a share of 0 or 1.
    low = 0.0 if successes == 0 else (centre - spread) / scale
    high = 1.0 if successes == trials else (centre + spread) / scale
    return Interval(low, high)
