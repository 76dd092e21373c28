"""From one command to the runs of a grid: every seed with every combination of settings."""

import dataclasses
import itertools
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mjxwalk.cli.argument_types import SEEDS
from mjxwalk.cli.evolve_arguments import EvolveArguments
from mjxwalk.cli.parsing import parse
from mjxwalk.errors import RunError
from mjxwalk.experiments.own_task import trust
from mjxwalk.sweep import plan as plans
from mjxwalk.sweep.plan import Plan, Resources

MOST_RUNS = 100_000  # ours: more folders than anybody wants to look at
LONGEST = 200  # letters of a name before the seed; a file's may have 255
SEED = "seed-"  # in a name, before the seed


def grid(asked: EvolveArguments, seeds: int) -> dict[str, EvolveArguments]:
    """Returns what each run is asked for, by a name that is fit for a folder.

    Args:
      asked: of every run; a setting may have several values, with commas between them.
      seeds: how many, from the one that is asked for.

    Raises:
      RunError: there are too many, a seed cannot be, or a setting has no value or is there twice.
    """
    settings = [
        (path.strip(), _values(path, text))
        for path, _, text in (s.partition("=") for s in asked.set)
    ]
    if seeds < 1:
        raise RunError(f"--seeds must be at least 1, got {seeds}")
    if asked.seed + seeds > SEEDS:
        raise RunError(
            f"{seeds} seeds from {asked.seed} upwards go past the last one, {SEEDS - 1}; give a "
            "smaller --seed"
        )
    number = seeds
    for _, values in settings:
        number *= len(values)
    if number > MOST_RUNS:
        raise RunError(f"these are {number} runs, more than {MOST_RUNS}; make several sweeps")
    _check_paths([path for path, _ in settings])
    names = _short_names([path for path, values in settings if len(values) > 1])
    beginnings: set[str] = set()
    runs: dict[str, EvolveArguments] = {}
    for choice in itertools.product(*[values for _, values in settings]):
        chosen = [(path, value) for (path, _), value in zip(settings, choice, strict=True)]
        parts = [f"{names[path]}-{_plain(value)}-" for path, value in chosen if path in names]
        beginning = "".join(parts)[:LONGEST]
        if beginning in beginnings:  # the values differ in what a folder's name cannot show
            beginning = f"{beginning}{len(beginnings)}-"
        beginnings.add(beginning)
        given = tuple(f"{path}={value}" for path, value in chosen)
        for seed in range(asked.seed, asked.seed + seeds):
            run = dataclasses.replace(_only_evolve(asked), seed=seed, set=given, out=None)
            runs[f"{beginning}{SEED}{seed}"] = run
    return runs


def make_plan(asked: EvolveArguments, seeds: int, resources: Resources) -> Plan:
    """Returns the plan of a grid; the arguments are those of `grid`.

    Raises:
      RunError: as in `grid`, or an argument cannot be kept in a file.
    """
    runs = grid(asked, seeds)
    return plans.make({name: arguments(run) for name, run in runs.items()}, resources)


def arguments(asked: EvolveArguments) -> list[str]:
    """Returns the arguments of `mjxwalk evolve` that ask for the same."""
    found = [asked.experiment]
    for field in dataclasses.fields(EvolveArguments):
        value: Any = getattr(asked, field.name)
        # What is trusted is so by its digest, and a folder's plan can give no trust.
        if field.name in ("experiment", "set", "trust") or value == field.default:
            continue
        flag = "from" if field.name == "source" else field.name.replace("_", "-")
        found.append(f"--{flag}")
        if value is not True:
            found.append("all" if value is None else str(value))
    for assignment in asked.set:
        found += ["--set", assignment]
    return found


def is_of_sweep(args: tuple[str, ...]) -> bool:
    """Returns whether `arguments` could have made these, for a run in the sweep's own folder.

    Raises:
      RunError: `mjxwalk evolve` does not take them.
    """
    asked = parse("mjxwalk evolve", EvolveArguments, args)
    leaves = asked.out is not None or asked.distributed or asked.live or asked.trust
    return not leaves and tuple(arguments(asked)) == args


def check_trust(path: Path, plan: Plan, *, is_given: bool) -> None:
    """Raises RunError unless the code that the runs of a sweep execute is trusted.

    Args:
      path: of the sweep's folder.
      plan: in it, from anybody.
      is_given: whether the user said to trust it.
    """
    for run in plan.runs:
        asked = parse("mjxwalk evolve", EvolveArguments, run.args)
        if not asked.is_task:
            continue
        file, sha256 = asked.experiment, asked.task_sha256 or "unknown"
        if is_given and asked.task_sha256:
            trust.trust(sha256, file)
        if not trust.is_trusted(sha256):
            raise RunError(
                f"{path} runs code that was not written on this machine: {file} (sha256 {sha256}); "
                "read it, and add --trust if you want it executed"
            )


def _only_evolve(asked: EvolveArguments) -> EvolveArguments:
    return EvolveArguments(
        **{field.name: getattr(asked, field.name) for field in dataclasses.fields(EvolveArguments)}
    )


def _values(path: str, text: str) -> list[str]:
    """Returns the values between the commas that stand in no brackets and no quotes."""
    values, depth, quoted = [""], 0, False
    for letter in text:
        quoted ^= letter == '"'
        depth += 0 if quoted else (letter in "[{") - (letter in "]}")
        if letter == "," and not depth and not quoted:
            values.append("")
        else:
            values[-1] += letter
    stripped = [value.strip() for value in values]
    if len(stripped) > 1 and not all(stripped):
        raise RunError(f"--set {path}={text} has a comma without a value beside it")
    return list(dict.fromkeys(stripped))


def _check_paths(paths: Sequence[str]) -> None:
    """Raises RunError if a setting is there twice: which of its values holds would be a guess."""
    for path in paths:
        if paths.count(path) > 1:
            raise RunError(f"--set {path} is there twice; put the values of both into one")


def _short_names(paths: Sequence[str]) -> dict[str, str]:
    """Returns the last part of each path, or as many more as it takes to tell them apart."""
    names: dict[str, str] = {}
    for path in paths:
        parts = path.split(".")
        ending = parts
        for length in range(len(parts), 0, -1):
            if sum(other.split(".")[-length:] == parts[-length:] for other in paths) == 1:
                ending = parts[-length:]
        names[path] = _plain("-".join(ending))
    return names


def _plain(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9.]+", "-", text).strip("-.")[:60] or "x"
