"""A sweep on disk: a folder with `sweep.json`, and in it a folder for each run."""

import hashlib
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, Literal

import msgspec

from mjxwalk import shell, terminal
from mjxwalk.errors import RunError
from mjxwalk.runs import digests, files
from mjxwalk.runs.locking import LOCK_FILE, locked

FILE = "sweep.json"
LOGS = "logs"  # folder with what each run said
SCHEMA = 1
RESUMED = ("--tensorboard",)  # flags of `evolve` that `resume` needs again
MOST_BYTES = 1 << 27  # ours: of a plan; the most runs, with a kilobyte of arguments each


class PlannedRun(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One run.

    Attributes:
      name: of its folder.
      args: of `mjxwalk evolve`, without its folder.
    """

    name: str
    args: tuple[str, ...]


class Resources(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What runs the runs.

    Attributes:
      executor: where they run.
      cores: of each run; None for what there is, shared out.
      memory_gb: that each run may take; None for no limit.
      address: of a Ray cluster; None for the one that Ray finds.
      partition: of Slurm; None for its default.
      hours: that a job of Slurm may take.
    """

    executor: Literal["local", "ray", "slurm"] = "local"
    cores: int | None = None
    memory_gb: float | None = None
    address: str | None = None
    partition: str | None = None
    hours: float = 24.0


class Plan(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All runs of a sweep, in the order in which they start."""

    runs: tuple[PlannedRun, ...]
    resources: Resources

    @property
    def name(self) -> str:
        """Tells this sweep's runs from those of any other."""
        text = msgspec.json.encode(self.runs)
        return hashlib.blake2b(text, digest_size=4).hexdigest()


class _File(Plan, frozen=True, kw_only=True, forbid_unknown_fields=True):
    schema: int
    digest: str | None = None


def make(runs: Mapping[str, Iterable[str]], resources: Resources) -> Plan:
    """Returns the plan of runs, by name the arguments of `mjxwalk evolve`.

    Raises:
      RunError: an argument cannot be kept in a file.
    """
    planned = tuple(PlannedRun(name=name, args=tuple(args)) for name, args in runs.items())
    for word in {word for run in planned for word in run.args}:
        if terminal.has_other_bytes(word):
            raise RunError(f"a sweep keeps its arguments, and {word!r} is no UTF-8 text; rename it")
    return Plan(runs=planned, resources=resources)


def resuming(args: Iterable[str]) -> tuple[str, ...]:
    """Returns what of a run's arguments it must be told again when it goes on."""
    return tuple(arg for arg in args if arg in RESUMED)


def is_sweep(path: Path) -> bool:
    """Returns whether a folder holds a sweep."""
    return (path / FILE).is_file()


def create(path: Path, plan: Plan) -> None:
    """Makes a sweep's folder, or returns if the same runs are planned in it already.

    Raises:
      RunError: the folder holds anything else, or cannot be made.
    """
    if is_sweep(path):
        _check_same(path, plan)
        return
    begun = (LOCK_FILE, files.partial(FILE))
    try:
        path.mkdir(parents=True, exist_ok=True)
        in_the_way = [each.name for each in path.iterdir() if each.name not in begun]
    except OSError as error:
        raise RunError(f"{path} could not be made: {files.describe(error)}") from error
    if in_the_way and not is_sweep(path):
        raise RunError(f"{path} exists and is not an empty folder; choose another --out")
    with locked(path):
        if is_sweep(path):  # another process was as quick
            _check_same(path, plan)
            return
        data: dict[str, Any] = {"schema": SCHEMA, **msgspec.to_builtins(plan)}
        files.replace(path, FILE, digests.with_digest(data))


def _check_same(path: Path, plan: Plan) -> None:
    """Raises RunError unless the same runs are planned in a folder."""
    if _read(path).runs != plan.runs:
        again = shell.command("resume", path)
        raise RunError(
            f"{path} holds another sweep; go on with it by `{again}`, or choose another --out"
        )


def read(path: Path, is_allowed: Callable[[tuple[str, ...]], bool]) -> Plan:
    """Returns the plan of a sweep.

    Args:
      path: of its folder.
      is_allowed: whether a sweep's run may have such arguments; the file comes from anybody.

    Raises:
      RunError: the folder holds none, or it was changed or asks for what a sweep does not do.
    """
    plan = _read(path)
    for run in plan.runs:
        if not is_allowed(run.args):
            raise RunError(f"{path / FILE} asks for what a sweep does not: {' '.join(run.args)}")
    return plan


def _read(path: Path) -> Plan:
    """Returns the plan of a sweep, whose runs may have any arguments."""
    file = path / FILE
    content = files.read_inside(path, FILE, MOST_BYTES)
    if content is None:
        raise RunError(f"{path} is no sweep: it has no {FILE}")
    schema = files.decode_table(file, content).get("schema")
    if isinstance(schema, int) and schema != SCHEMA:
        raise RunError(f"{file} has version {schema} and this mjxwalk reads version {SCHEMA}")
    found = files.decode(file, content, _File)
    digests.check(file, content, needed=True)
    for run in found.runs:
        if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9.-]*", run.name) or run.name == LOGS:
            raise RunError(f"{file} has a run named {run.name!r}, which is no name for its folder")
    return Plan(runs=found.runs, resources=found.resources)
