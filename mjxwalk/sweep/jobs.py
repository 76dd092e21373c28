"""A run of a sweep as a job, and what takes jobs; what they need wherever they run."""

import contextlib
from collections.abc import Callable, Sequence
from io import FileIO
from pathlib import Path
from typing import NamedTuple, Protocol, TypeAlias, runtime_checkable

from mjxwalk.runs import files

# Runs a command of mjxwalk in this process, and returns its exit code.
Main: TypeAlias = Callable[[Sequence[str]], int]

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
          RunError: where it is to run cannot be reached.
        """
        ...

    def close(self) -> None:
        """Lets go of what it holds."""
        ...


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
