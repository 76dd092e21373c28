"""What to type to report on a sweep."""

import fnmatch
from pathlib import Path

from mjxwalk import shell
from mjxwalk.sweep.plan import Plan

MOST = 8  # commands that are shown; ours: as many as a screen has room for


def commands(path: Path, plan: Plan) -> list[str]:
    """Returns a command for each choice of settings: only runs that share them can be averaged.

    Args:
      path: of the sweep's folder.
      plan: its runs.
    """
    groups: dict[tuple[str, ...], list[str]] = {}
    for run in plan.runs:
        groups.setdefault(_without_seed(run.args), []).append(run.name)
    names = [run.name for run in plan.runs]
    found = [_command(path, group, names, len(groups)) for group in groups.values()]
    more = [f"... {len(found) - MOST} more, one for each choice of settings"]
    return found if len(found) <= MOST else [*found[:MOST], *more]


def _command(path: Path, group: list[str], names: list[str], num_groups: int) -> str:
    pattern = f"{group[0].rpartition('seed-')[0]}seed-*"
    if fnmatch.filter(names, pattern) == group:
        runs = f"{shell.quoted(path)}/{pattern}"
    else:
        runs = " ".join(shell.quoted(path / name) for name in group)
    # Pages of several runs go to ./report, where each would replace the one before.
    is_alone = num_groups == 1 or len(group) == 1
    out = "" if is_alone else f" --out {shell.quoted(path / f'report-{group[0]}')}"
    return f"{shell.command('report')} {runs}{out}"


def _without_seed(args: tuple[str, ...]) -> tuple[str, ...]:
    if "--seed" not in args:
        return args
    place = args.index("--seed")
    return (*args[:place], *args[place + 2 :])
