"""What can run the runs of a sweep."""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from io import FileIO
from pathlib import Path
from typing import NamedTuple, Protocol, runtime_checkable

from mjxwalk import budget
from mjxwalk.errors import RunError
from mjxwalk.runs import files, locking
from mjxwalk.sweep.plan import Resources
from mjxwalk.sweep.worker import Main

# Tests put another in its place.
PROGRAM: tuple[str, ...] = (sys.executable, "-m", "mjxwalk")
THREADS = "MJXWALK_LANES_THREADS"
GIGABYTE = 1_000_000_000
LEAST_GB = 0.4  # ours: a small run fills 0.57 GB on two cores; with a third of that JAX hangs


class Job(NamedTuple):
    """A run to work on.

    Attributes:
      name: of the run.
      args: of mjxwalk: to begin the run or to go on with it.
      path: of the run's folder.
      log: file for what it says.
    """

    name: str
    args: tuple[str, ...]
    path: Path
    log: Path


@runtime_checkable
class Handle(Protocol):
    """A job that was started."""

    def is_done(self) -> bool:
        """Returns whether it has ended, well or not: its folder tells which."""
        ...

    def reason(self) -> str | None:
        """Returns why a job that is done could say nothing itself; None if it could."""
        ...

    def stop(self) -> None:
        """Asks it to save and end."""
        ...


@runtime_checkable
class Executor(Protocol):
    """Starts jobs.

    Attributes:
      slots: jobs that it takes at a time.
      where: in words.
    """

    slots: int
    where: str

    def start(self, job: Job) -> Handle | None:
        """Starts a job, or has it wait for its turn elsewhere; None if it is at work already.

        Raises:
          OSError: it cannot be started.
          RunError: likewise.
        """
        ...

    def close(self) -> None:
        """Lets go of what it holds."""
        ...


def make(resources: Resources, num_runs: int, folder: Path, main: Main) -> Executor:
    """Returns the executor that was asked for.

    Args:
      resources: that were asked for.
      num_runs: that it will start.
      folder: of the sweep.
      main: runs a command of mjxwalk in the process of a cluster, and returns its exit code.

    Raises:
      RunError: it is not installed, not there, or too small for one run.
    """
    if resources.executor == "ray":
        from mjxwalk.sweep.on_ray import OnRay

        return OnRay(resources, main)
    if resources.executor == "slurm":
        from mjxwalk.sweep.on_slurm import OnSlurm

        return OnSlurm(resources, folder, main)
    return Local(resources, num_runs)


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


def open_log(path: Path) -> FileIO:
    """Returns the file for what a run says, to add to.

    Raises:
      RunError: it cannot be written, or it or its folder is a link.
    """
    return files.open_append(path.parents[1], f"{path.parent.name}/{path.name}")


def limit_memory(pid: int, gigabytes: float) -> None:
    """Limits the memory that a process may fill, where the system can."""
    try:
        import resource
    except ImportError:  # Windows: a run can take the memory of the others
        return
    if hasattr(resource, "prlimit"):
        # Not RLIMIT_AS: JAX reserves addresses by the dozen gigabytes and fills few of them.
        most = int(gigabytes * GIGABYTE)
        with contextlib.suppress(ProcessLookupError):  # it has ended already
            _, before = resource.prlimit(pid, resource.RLIMIT_DATA)
            most = most if before == resource.RLIM_INFINITY else min(most, before)
            resource.prlimit(pid, resource.RLIMIT_DATA, (most, most))


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
