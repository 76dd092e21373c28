"""What can run the runs of a sweep."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, Protocol, runtime_checkable

from mjxwalk.errors import RunError
from mjxwalk.sweep.plan import Resources

# Tests put another in its place.
PROGRAM: tuple[str, ...] = (sys.executable, "-m", "mjxwalk")
THREADS = "MJXWALK_LANES_THREADS"
GIGABYTE = 1_000_000_000


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

    def start(self, job: Job) -> Handle:
        """Starts a job, or has it wait for its turn elsewhere."""
        ...

    def close(self) -> None:
        """Lets go of what it holds."""
        ...


def make(resources: Resources, num_runs: int, folder: Path) -> Executor:
    """Returns the executor that was asked for.

    Raises:
      RunError: it is not installed, not there, or too small for one run.
    """
    if resources.executor == "ray":
        from mjxwalk.sweep.on_ray import OnRay

        return OnRay(resources)
    if resources.executor == "slurm":
        from mjxwalk.sweep.on_slurm import OnSlurm

        return OnSlurm(resources, folder)
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

    def start(self, job: Job) -> "_Process":
        """Starts a process on the next free cores."""
        slot = self._free.pop(0)
        environment = {**os.environ, THREADS: str(len(slot.cores))}
        if slot.gpu is not None:
            environment["CUDA_VISIBLE_DEVICES"] = slot.gpu
        command = [*PROGRAM, *job.args]
        with job.log.open("ab") as log, _Pinned(slot.cores):
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=environment,
                start_new_session=True,  # Ctrl-C comes to us alone, and we pass it on
            )
        if self._memory_gb is not None:
            limit_memory(process.pid, self._memory_gb)
        return _Process(process, lambda: self._free.append(slot))

    def close(self) -> None:
        """Has nothing to let go of."""


class _Process:
    def __init__(self, process: subprocess.Popen[bytes], release: "object") -> None:
        self._process = process
        self._release = release

    def is_done(self) -> bool:
        if self._process.poll() is None:
            return False
        release, self._release = self._release, None
        if callable(release):
            release()
        return True

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


def limit_memory(pid: int, gigabytes: float) -> None:
    """Limits the memory that a process may fill, where the system can."""
    import resource

    if hasattr(resource, "prlimit"):
        # Not RLIMIT_AS: JAX reserves addresses by the dozen gigabytes and fills few of them.
        most = int(gigabytes * GIGABYTE)
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
    listed = subprocess.run(["nvidia-smi", "-L"], capture_output=True, text=True, check=False)
    return [str(n) for n, _ in enumerate(listed.stdout.splitlines()) if listed.returncode == 0]


def _fitting(gigabytes: float) -> int:
    available = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / GIGABYTE
    if gigabytes > available:
        raise RunError(
            f"--memory-per-run is {gigabytes:g} GB, and this machine has {available:.3g} GB"
        )
    return int(available // gigabytes)
