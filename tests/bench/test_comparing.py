"""Tests of how strategies are compared, on figures that are made up."""

import numpy as np
import pytest

from mjxwalk import strategies
from mjxwalk.bench import comparing, searches
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


def _comparison(*qualities: Quality) -> Comparison:
    return Comparison(device="cpu", sizes=comparing.QUICK, times=[], qualities=list(qualities))


def test_what_is_worse_is_named():
    shown = comparing.remarks(_comparison(_quality("snes", SAME), _quality("xnes", WORSE)))
    assert shown[-1].endswith("2 comparisons, by Holm: xnes on sphere 10, evosax")


def test_holms_procedure_asks_less_of_each_that_follows():
    # Levels are 0.05 / 3, 0.05 / 2 and 0.05: Bonferroni would keep only the first.
    lost = _comparison(_quality("a", 0.01), _quality("b", 0.06), _quality("c", 0.02)).worse
    assert [quality.strategy for quality in lost] == ["a", "c"]
    assert not _comparison(_quality("a", 0.02), _quality("b", 0.03), _quality("c", 0.03)).worse


def test_rows_stand_below_their_heads():
    head = comparing.head_of_times(_comparison())[-1]
    row = comparing.row_of_time(Time(strategy="snes", num_weights=1_000, ours=0.1, evosax=0.25))
    assert row.split() == ["snes", "1,000", "100", "ms", "250", "ms", "2.5"]
    assert len(row) == len(head)
    head = comparing.head_of_qualities(_comparison())[-1]
    row = comparing.row_of_quality(_quality("snes", SAME))
    assert row.index("1.0e+00") == head.index("ours") and len(row) == len(head)


def test_each_row_is_told_as_it_comes_and_searches_find_the_lowest(
    monkeypatch: pytest.MonkeyPatch,
):
    pair = searches.Pair(
        lambda size: strategies.snes(population_size=size, sigma=1.0),
        lambda size, num_weights: strategies.snes(population_size=size, sigma=1.0),
        num_weights=3,
    )
    monkeypatch.setattr(searches, "pairs", lambda: {"snes": pair})
    sizes = comparing.Sizes(population_size=8, repeats=1, dimensions=(2,), generations=60, seeds=3)
    told: list[str] = []
    found = comparing.compare(sizes, told.append)
    assert [line.split()[1] for line in told if line.startswith("snes")] == [
        "3",
        *searches.FUNCTIONS,
    ]
    # The same on either side, from the same seeds.
    assert all(quality.p_worse == 1.0 for quality in found.qualities)
    assert found.qualities[0].function == "sphere" and found.qualities[0].ours[2] < 0.01
