"""Running a kernel: threads that share the walkers, and can be interrupted."""

import functools
import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any

import numpy as np

from mjxwalk.engines.lanes.backend.machine_code import Loaded
from mjxwalk.engines.lanes.ir.graph import Array

ALIGNMENT = 64  # bytes: a cache line, and the longest vector
POLL = 0.1  # s between looks for an interrupt
CPU_QUOTAS = (Path("/sys/fs/cgroup/cpu.max"),)


def num_threads(asked: int | None = None) -> int:
    """Returns how many threads to run: as asked, or MJXWALK_LANES_THREADS, or the CPUs there are.

    The CPUs are those that the process may use, less if its control group grants less time.
    """
    if asked is None and os.environ.get("MJXWALK_LANES_THREADS"):
        told = os.environ["MJXWALK_LANES_THREADS"]
        if not told.isdecimal():
            raise ValueError(f"MJXWALK_LANES_THREADS must be a whole number, got {told!r}")
        asked = int(told)
    if asked is not None:
        if asked < 1:
            raise ValueError(f"threads must be at least 1, got {asked}")
        return asked
    if hasattr(os, "sched_getaffinity"):
        usable = len(os.sched_getaffinity(0))
    else:
        usable = os.cpu_count() or 1
    for quota in map(_quota, CPU_QUOTAS):
        if quota is not None:
            usable = min(usable, max(1, math.ceil(quota)))
    return usable


def devices() -> str:
    """Returns how many threads run kernels, in words."""
    return f"{num_threads()} CPU threads"


def _quota(path: Path) -> float | None:
    """Returns the CPUs' worth of time that a control group grants, or None if it sets no limit."""
    try:
        granted, period = path.read_text(encoding="utf-8").split()
        return None if granted == "max" else int(granted) / int(period)
    except (OSError, ValueError):
        return None


def run(
    loaded: Loaded,
    workspace: int,
    inputs: Sequence[Array],
    outputs: Sequence[Array],
    count: int,
    workers: int,
) -> float:
    """Runs the kernel over `count` walkers; returns the share of lane-iterations with a walker.

    Args:
      workspace: bytes of memory that each thread needs.
      inputs, outputs: contiguous arrays; the outputs are written.
    """
    if count == 0:
        return 1.0
    following, stop = np.zeros(1, np.int64), np.zeros(1, np.int32)
    spent = np.zeros((workers, ALIGNMENT // 8), np.int64)  # a cache line each
    memories = [_aligned(workspace) for _ in range(workers)]
    given, taken = _pointers(inputs), _pointers(outputs)

    def work(number: int) -> None:
        loaded.call(given.ctypes.data, taken.ctypes.data, memories[number].ctypes.data, count,
                    following.ctypes.data, stop.ctypes.data, spent[number].ctypes.data)  # fmt: skip

    crew = _crew(workers)
    working = {crew.submit(work, number) for number in range(workers)}
    try:
        while working:
            done, working = wait(working, POLL)  # the lock is released: handlers of signals run
            for worker in done:
                worker.result()
    except BaseException:
        stop[0] = 1
        wait(working)
        raise
    busy, everything = spent[:, 0].sum(), spent[:, 1].sum()
    return float(busy / everything) if everything else 1.0


@functools.cache
def _crew(workers: int) -> ThreadPoolExecutor:
    """Returns threads that stay: to start them takes a millisecond, as much as short trials do."""
    return ThreadPoolExecutor(workers, thread_name_prefix="lanes")


if hasattr(os, "register_at_fork"):  # a forked process has none of its parent's threads
    os.register_at_fork(after_in_child=_crew.cache_clear)


def _aligned(size: int) -> Array:
    """Returns zeroed memory that starts on a cache line."""
    memory: Any = np.zeros(size + ALIGNMENT, np.uint8)
    return memory[-memory.ctypes.data % ALIGNMENT :][:size]


def _pointers(arrays: Sequence[Array]) -> Array:
    return np.array([array.ctypes.data for array in arrays] or [0], np.uint64)
