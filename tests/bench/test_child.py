"""Tests of what is measured in fresh processes."""

import pytest

from mjxwalk.bench import child
from mjxwalk.errors import RunError


@pytest.mark.slow
def test_compiling_is_timed_without_and_with_a_cache() -> None:
    cold, warm = child.compile_seconds("planar")
    assert cold > 0 and warm > 0


@pytest.mark.slow
def test_memory_is_told_before_and_after_the_population() -> None:
    memory = child.peak_memory("planar", 64)
    assert memory["after"] >= memory["before"] > 10 << 20  # no process with JAX is smaller


def test_a_process_that_fails_is_told_in_a_sentence() -> None:
    with pytest.raises(RunError, match=r"child memory body 1` failed: KeyError: 'body'"):
        child.peak_memory("body", 1)
