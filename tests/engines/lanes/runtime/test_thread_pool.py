"""Threads: how many, whether they can be stopped, and whether Python lives on beside them."""

import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jax import lax

from mjxwalk.engines import lanes
from mjxwalk.engines.lanes.runtime import thread_pool


class Alarm(Exception):
    """Raised by the test's signal."""


def endless(x: Any) -> Any:
    """Counts for ever."""
    return lax.while_loop(lambda i: i < 2.0, lambda i: i * 0.5, x)


def test_a_signal_stops_a_kernel_that_would_never_end() -> None:
    def ring(*_: Any) -> None:
        raise Alarm

    mapped = lanes.vmap(endless)
    mapped.prepare(np.ones(1, np.float32))
    others = threading.active_count()
    before = signal.signal(signal.SIGALRM, ring)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        start = time.perf_counter()
        with pytest.raises(Alarm):
            mapped(np.ones(100, np.float32))
        assert time.perf_counter() - start < 5
    finally:
        signal.signal(signal.SIGALRM, before)
    assert threading.active_count() <= others + mapped.threads  # no more than stay for the next


def test_python_goes_on_while_a_kernel_runs() -> None:
    turns: list[float] = []
    ended = threading.Event()

    def tick() -> None:
        while not ended.wait(0.005):
            turns.append(time.perf_counter())

    mapped = lanes.vmap(lambda x: lax.fori_loop(0, 3_000_000, lambda i, s: s * 0.999 + x, x))
    mapped.prepare(np.ones(1, np.float32))
    ticking = threading.Thread(target=tick)
    ticking.start()
    start = time.perf_counter()
    mapped(np.ones(64, np.float32))
    elapsed = time.perf_counter() - start
    ended.set()
    ticking.join()
    assert len(turns) > elapsed / 0.005 / 20  # a machine under load may be late, not absent


def test_threads_are_as_asked_then_as_the_environment_says(monkeypatch: Any) -> None:
    monkeypatch.setenv("MJXWALK_LANES_THREADS", "7")
    assert thread_pool.num_threads(3) == 3
    assert thread_pool.num_threads() == 7
    monkeypatch.delenv("MJXWALK_LANES_THREADS")
    assert thread_pool.num_threads() >= 1
    with pytest.raises(ValueError, match="threads must be at least 1, got 0"):
        thread_pool.num_threads(0)


@pytest.mark.parametrize(
    "text, threads", [("150000 100000", 2), ("50000 100000", 1), ("max 100000", 64), ("?", 64)]
)
def test_threads_keep_to_the_quota_of_the_control_group(
    text: str, threads: int, tmp_path: Path, monkeypatch: Any
) -> None:
    quota = tmp_path / "cpu.max"
    quota.write_text(text)
    monkeypatch.delenv("MJXWALK_LANES_THREADS", raising=False)
    monkeypatch.setattr(thread_pool, "CPU_QUOTAS", (quota,))
    monkeypatch.setattr(thread_pool.os, "sched_getaffinity", lambda _: range(64), raising=False)
    assert thread_pool.num_threads() == threads


def test_a_width_that_no_vector_has_is_refused() -> None:
    with pytest.raises(ValueError, match=r"width must be one of \(4, 8, 16\), got 5"):
        lanes.vmap(endless, width=5)


FORKED = """
import os, sys
import numpy as np
from mjxwalk.engines import lanes

mapped = lanes.vmap(lambda x: x * 2.0)
x = np.arange(4096, dtype=np.float32)
mapped(x)
child = os.fork()
if child == 0:
    os._exit(0 if (mapped(x) == 2 * x).all() else 1)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


def test_kernel_runs_in_a_process_that_was_forked_after_it_had_run() -> None:
    done = subprocess.run([sys.executable, "-c", FORKED], timeout=120, check=False)
    assert done.returncode == 0
