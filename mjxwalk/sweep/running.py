"""Takes a sweep to its end: starts what waits, looks at what runs, and tells of what failed."""

import dataclasses
import time
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Literal, Protocol, runtime_checkable

from mjxwalk import shell
from mjxwalk.errors import Interrupted, RunError
from mjxwalk.runs import files, folder
from mjxwalk.sweep import executors, run_progress
from mjxwalk.sweep.jobs import Executor, Handle, Job, Main
from mjxwalk.sweep.plan import LOGS, Plan, PlannedRun, resuming
from mjxwalk.sweep.run_progress import RunProgress

State = Literal["waiting", "running", "finished", "failed", "stopped"]
INTERVAL = 0.25  # s between looks
PATIENCE = 120.0  # s that runs may take to save and end


@dataclasses.dataclass(kw_only=True)
class Row:
    """How one run gets on.

    Attributes:
      state: as far as this sweep knows.
      look: what its folder tells.
      reason: why it failed.
    """

    state: State = "waiting"
    progress: RunProgress = RunProgress()
    reason: str = ""


@runtime_checkable
class Display(Protocol):
    """Shows a sweep."""

    def start(self, path: Path, where: str, rows: Mapping[str, Row], /) -> None:
        """Shows what is about to run, and where."""
        ...

    def update(self, rows: Mapping[str, Row], slots: int, /) -> None:
        """Shows how all runs get on."""
        ...

    def say(self, text: str, /) -> None:
        """Shows a sentence."""
        ...

    def close(self) -> None:
        """Gives the terminal back; may be called again."""
        ...


def go_on(
    path: Path,
    plan: Plan,
    display: Display,
    stopping: Callable[[], bool],
    main: Main,
) -> dict[str, Row]:
    """Takes the runs that are not finished to their ends, and returns how all of them ended.

    Args:
      path: of the sweep's folder.
      plan: in its `sweep.json`.
      display: shows it.
      stopping: whether to stop.
      main: runs a command of mjxwalk in the process of a cluster, and returns its exit code.

    Raises:
      RunError: another process works on the sweep, or its executor is not there.
      Interrupted: the user stopped it.
    """
    with folder.locked(path):
        rows = {run.name: Row(progress=run_progress.read(path / run.name)) for run in plan.runs}
        left = [run for run in plan.runs if not rows[run.name].progress.is_finished]
        for name in rows.keys() - {run.name for run in left}:
            rows[name].state = "finished"
        if not left:
            return rows
        files.make_folder(path, LOGS)
        executor = executors.make(plan.resources, len(left), path, main)
        try:
            display.start(path, executor.where, rows)
            _work(path, left, rows, executor, display, stopping)
        finally:
            display.close()
            executor.close()
        return rows


def _work(
    path: Path,
    left: list[PlannedRun],
    rows: dict[str, Row],
    executor: Executor,
    display: Display,
    stopping: Callable[[], bool],
) -> None:
    waiting, running = deque(left), dict[str, Handle]()
    try:
        while waiting or running:
            if stopping():
                raise KeyboardInterrupt
            for _ in range(min(len(waiting), executor.slots - len(running))):
                run = waiting.popleft()
                _start(path, run, rows[run.name], executor, running, display)
                if rows[run.name].state == "waiting":
                    waiting.append(run)
            _settle(path, running, rows, display)
            display.update(rows, executor.slots)
            time.sleep(INTERVAL)
    except KeyboardInterrupt:
        _stop(path, running, rows)
        done = sum(row.state == "finished" for row in rows.values())
        raise Interrupted(f"stopped with {done} of {len(rows)} runs finished") from None


def _start(
    path: Path,
    run: PlannedRun,
    row: Row,
    executor: Executor,
    running: dict[str, Handle],
    display: Display,
) -> None:
    """Starts a run, unless a process that was left over from a sweep that was killed has it."""
    if folder.is_locked(path / run.name):
        return
    try:
        handle = executor.start(_job(path, run))
    except (OSError, RunError) as error:
        why = files.describe(error) if isinstance(error, OSError) else str(error)
        row.state, row.reason = "failed", f"it could not be started: {why}"
        display.say(f"{run.name} failed: {row.reason}")
        return
    if handle is not None:
        row.state, running[run.name] = "running", handle


def _settle(path: Path, running: dict[str, Handle], rows: dict[str, Row], display: Display) -> None:
    """Looks at what runs, and takes out what has ended."""
    for name, handle in list(running.items()):
        ended = handle.is_done()  # before the look, which then sees all that it wrote
        row = rows[name]
        row.progress = run_progress.read(path / name)
        if not ended:
            continue
        del running[name]
        row.state = "finished" if row.progress.is_finished else "failed"
        if row.state == "failed":
            row.reason = handle.reason() or _last_line(path / LOGS / f"{name}.log")
            display.say(f"{name} failed: {row.reason}")


def _stop(path: Path, running: dict[str, Handle], rows: dict[str, Row]) -> None:
    for handle in running.values():
        handle.stop()
    deadline = time.monotonic() + PATIENCE
    for name, handle in running.items():
        while not handle.is_done() and time.monotonic() < deadline:
            time.sleep(INTERVAL)
        rows[name].progress = run_progress.read(path / name)
        rows[name].state = "finished" if rows[name].progress.is_finished else "stopped"


def _job(path: Path, run: PlannedRun) -> Job:
    place = path / run.name
    begun = run_progress.read(place).is_begun
    again = ("resume", str(place), *resuming(run.args))
    args = again if begun else ("evolve", *run.args, "--out", str(place))
    return Job(run.name, args, place, path / LOGS / f"{run.name}.log")


def _last_line(log: Path) -> str:
    """Returns the last that a run said, which is the reason where it failed."""
    lines = files.read_end(log.parents[1], f"{LOGS}/{log.name}", 4096).decode(errors="replace")
    spoken = [line.strip() for line in lines.split("\n") if line.strip()]
    return spoken[-1][:300].removeprefix("mjxwalk: ") if spoken else f"it said nothing; see {log}"


def check_ended(path: Path, rows: Mapping[str, Row]) -> None:
    """Returns if all runs are finished.

    Raises:
      RunError: some failed; tells which, and the reason of the first.
    """
    failed = [name for name, row in rows.items() if row.state == "failed"]
    if failed:
        shown = ", ".join(failed[:5]) + (", ..." if len(failed) > 5 else "")
        raise RunError(
            f"{len(failed)} of {len(rows)} runs failed: {shown}; {failed[0]}: "
            f"{rows[failed[0]].reason}; what each said is in {path / LOGS}, and "
            f"`{shell.command('resume', path)}` tries them again"
        )
