"""Tests of how strategies are compared, on figures that are made up."""

import numpy as np

from mjxwalk.bench import comparing
from mjxwalk.bench.comparing import Comparison, Quality, Time

WORSE, SAME = 1e-6, 0.4


def _quality(strategy: str, p_worse: float) -> Quality:
    return Quality(
        strategy=strategy,
        function="sphere",
        num_weights=10,
        other="evosax",
        ours=(1.0, 2.0, 3.0),
        others=(1.0, 2.0, 3.0),
        p_worse=p_worse,
    )


def test_higher_values_are_worse_and_converged_ones_equal():
    low, high = np.linspace(1, 2, 20), np.linspace(3, 4, 20)
    assert comparing.p_worse(high, low) < 1e-6
    assert comparing.p_worse(low, high) > 0.99
    assert comparing.p_worse(np.full(20, 1e-9), np.full(20, 1e-20)) == 1.0
    assert comparing.p_worse(np.full(20, np.nan), low) < 1e-6


def test_what_is_worse_is_named_beside_the_times():
    comparison = Comparison(
        device="cpu",
        sizes=comparing.QUICK,
        times=[Time(strategy="snes", num_weights=1_000, ours=0.1, evosax=0.25)],
        qualities=[_quality("snes", SAME), _quality("xnes", WORSE)],
    )
    times, qualities = comparing.sections(comparison)
    assert times.rows == [("snes", "1,000", "100 ms", "250 ms", "2.5")]
    assert qualities.remarks[-1].endswith("2 comparisons: xnes on sphere 10")
