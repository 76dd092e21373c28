"""Runs of a sweep as processes on this machine."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from typing import NamedTuple

from mjxwalk import budget
from mjxwalk.errors import RunError
from mjxwalk.runs import locking
from mjxwalk.sweep.jobs import GIGABYTE, THREADS, Job, limit_memory, open_log
from mjxwalk.sweep.plan import Resources

# Tests put another in its place.
PROGRAM: tuple[str, ...] = (sys.executable, "-m", "mjxwalk")


class _Slot(NamedTuple):
    cores: tuple[int, ...]
    gpu: str | None


class Local:
    """Processes on this machine, each pinned to cores of its own and, where there are GPUs, to one.

    Attributes:
      slots: runs at a time.
      where: in words.
    """

    def __init__(self, resources: Resources, num_runs: int) -> None:
        cores = _cores()
        each = resources.cores or max(1, len(cores) // num_runs)
        if each > len(cores):
            raise RunError(f"--cores-per-run is {each}, and this machine lends {len(cores)} cores")
        gpus = _gpus()
        self.slots = len(cores) // each
        if gpus:
            self.slots = min(self.slots, len(gpus))
        if resources.memory_gb is not None:
            self.slots = min(self.slots, _fitting(resources.memory_gb))
        self._free = [
            _Slot(cores[n * each : (n + 1) * each], gpus[n] if gpus else None)
            for n in range(self.slots)
        ]
        self._memory_gb = resources.memory_gb
        unit = "core" if each == 1 else "cores"
        self.where = f"{self.slots} at a time on this machine, {each} {unit} each"

    def start(self, job: Job) -> "_Process | None":
        """Starts a process on the next free cores, unless one that was left over is at work.

        Raises:
          OSError: it cannot be started, or its log not be written.
        """
        slot = self._free[0]
        # Unbuffered, so that what it says is in the log, in order, whatever ends it.
        environment = {**os.environ, THREADS: str(len(slot.cores)), "PYTHONUNBUFFERED": "1"}
        if slot.gpu is not None:
            environment["CUDA_VISIBLE_DEVICES"] = slot.gpu
        with open_log(job.log) as log:
            # The process has the log open as long as it lives, and the lock with it. Not so on
            # Windows, where the lock of the run's own folder is what keeps a second process out.
            if not locking.is_free(log.fileno(), job.log):
                return None
            with _Pinned(slot.cores):
                process = subprocess.Popen(
                    [*PROGRAM, *job.args],
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    env=environment,
                    start_new_session=True,  # Ctrl-C comes to us alone, and we pass it on
                )
        if self._memory_gb is not None:
            limit_memory(process.pid, self._memory_gb)
        return _Process(process, self._free.pop(0), self._free, self._memory_gb is not None)

    def close(self) -> None:
        """Has nothing to let go of."""


class _Process:
    def __init__(
        self,
        process: subprocess.Popen[bytes],
        slot: _Slot,
        free: list[_Slot],
        is_limited: bool,
    ) -> None:
        self._process = process
        self._is_limited = is_limited
        self._slot: _Slot | None = slot
        self._free = free

    def is_done(self) -> bool:
        if self._process.poll() is None:
            return False
        if self._slot is not None:
            self._free.append(self._slot)
            self._slot = None
        return True

    def reason(self) -> str | None:
        code = self._process.returncode
        return signalled(-code, is_limited=self._is_limited) if code < 0 else None

    def stop(self) -> None:
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)


class _Pinned:
    """While entered, what this thread starts runs on some cores only."""

    def __init__(self, cores: Sequence[int]) -> None:
        self._cores = cores

    def __enter__(self) -> None:
        if hasattr(os, "sched_setaffinity"):
            self._before = os.sched_getaffinity(0)
            os.sched_setaffinity(0, self._cores)

    def __exit__(self, *_: object) -> None:
        if hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, self._before)


def signalled(number: int, *, is_limited: bool) -> str:
    """Returns what is said of a process that a signal ended, and of the likely reason."""
    names = {int(each): each.name for each in signal.Signals}
    told = f"it was ended by signal {number} ({names.get(number, 'unknown')})"
    if names.get(number) == "SIGKILL":
        return f"{told}, as the system does where memory runs out"
    if number == signal.SIGABRT and is_limited:
        return f"{told}, as happens where --memory-per-run is too little"
    return told


def _cores() -> tuple[int, ...]:
    if hasattr(os, "sched_getaffinity"):
        return tuple(sorted(os.sched_getaffinity(0)))
    return tuple(range(os.cpu_count() or 1))


def _gpus() -> list[str]:
    """Returns the NVIDIA GPUs that this process may use, as CUDA_VISIBLE_DEVICES names them."""
    told = os.environ.get("CUDA_VISIBLE_DEVICES")
    if told is not None:
        return [each for each in told.split(",") if each]
    if shutil.which("nvidia-smi") is None:
        return []
    listed = subprocess.run(
        ["nvidia-smi", "-L"], capture_output=True, encoding="utf-8", check=False
    )
    return [str(n) for n, _ in enumerate(listed.stdout.splitlines()) if listed.returncode == 0]


def _fitting(gigabytes: float) -> int:
    available = budget.machine() / GIGABYTE
    if gigabytes > available:
        raise RunError(
            f"--memory-per-run is {gigabytes:g} GB, and this machine has {available:.3g} GB"
        )
    return int(available // gigabytes)
