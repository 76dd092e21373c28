"""Works on one run of a sweep in the process of a cluster, on whatever machine that is."""

import contextlib
import io
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from mjxwalk.runs import config, folder
from mjxwalk.sweep import jobs
from mjxwalk.sweep.jobs import Main
from mjxwalk.sweep.plan import resuming

WAITING = 600.0  # s for a process before us, whose machine was lost, to let go of the run


def work(
    main: Main,
    args: Sequence[str],
    path: str,
    log: str,
    cores: int,
    memory_gb: float | None,
) -> int:
    """Begins a run, or goes on with it, and returns the exit code.

    Args:
      main: runs a command of mjxwalk in this process.
      args: of the command that begins the run.
      path: of its folder, on a disk that all machines share.
      log: file for what it says.
      cores: for the threads of the lanes engine.
      memory_gb: that it may take; None for no limit.
    """
    os.environ[jobs.THREADS] = str(cores)
    if memory_gb is not None:
        jobs.limit_memory(os.getpid(), _taken_gb() + memory_gb)

    place = Path(path)
    deadline = time.monotonic() + WAITING
    while folder.is_locked(place) and time.monotonic() < deadline:
        time.sleep(1.0)
    if (place / config.FILE).is_file():  # begun before: by a job that was cut short, say
        args = ("resume", path, *resuming(args))
    log_file = io.BufferedWriter(jobs.open_log(Path(log)))
    with io.TextIOWrapper(
        log_file, encoding="utf-8", errors="backslashreplace", line_buffering=True
    ) as said:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            try:
                return main(args)
            finally:
                sys.stdout.flush()


def _taken_gb() -> float:
    """Returns what the cluster's part of this process has reserved; 0 where that is not told."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[5])
    except (OSError, ValueError, IndexError):
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e9
