"""Tests of what is measured in fresh processes."""

import pytest

from mjxwalk.bench import child
from mjxwalk.errors import RunError


@pytest.mark.slow
def test_compiling_is_timed_without_and_with_a_cache() -> None:
    points = child.compiling("planar7-points")
    assert 0 < points.warm < points.cold and points.code_bytes > 10_000
    touching = child.compiling("planar7")
    assert 0 < touching.warm < 0.5 * touching.cold and touching.code_bytes > points.code_bytes


@pytest.mark.slow
def test_memory_is_told_before_and_after_the_population() -> None:
    memory = child.peak_memory("planar7-points", 64)
    assert memory["after"] >= memory["before"] > 10 << 20  # no process with JAX is smaller


def test_a_process_that_fails_is_told_in_a_sentence() -> None:
    with pytest.raises(RunError, match=r"child memory body 1` failed: KeyError: 'body'"):
        child.peak_memory("body", 1)
