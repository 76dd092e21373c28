"""`mjxwalk list`."""

import dataclasses
from pathlib import Path

from mjxwalk import experiments, robots, terminal


@dataclasses.dataclass(frozen=True, kw_only=True)
class List:
    """Show experiments, controllers, bodies and walkers that ship, and the runs in a folder.

    Attributes:
      runs: folder with runs in it.
    """

    runs: Path = Path("runs")

    def run(self) -> int:
        """Prints six tables and returns the exit code."""
        named = experiments.names() | experiments.studies()
        phases = {study: experiments.phases(study) for study in experiments.studies()}
        print("Experiments")
        _print_table([(name, named[name]) for name in named if name.split("/")[0] not in phases])
        print("\nStudies and their phases")
        names = [[study, *(f"{study}/{phase}" for phase in phases[study])] for study in phases]
        _print_table([(name, named[name]) for study in names for name in study])
        print("\nControllers (--controller)")
        _print_table(list(experiments.CONTROLLERS.items()))
        print("\nBodies")
        _print_table([(name, body.summary) for name, body in robots.BODIES.items()])
        print("\nZoo")
        _print_table(_zoo())
        found = sorted(self.runs.iterdir()) if self.runs.is_dir() else []
        rows = [row for path in found for row in _describe_all(path)]
        print(f"\nRuns in {self.runs}" if rows else f"\nNo runs in {self.runs}")
        _print_table(rows)
        return 0


def _zoo() -> list[tuple[str, ...]]:
    """Returns each walker's source and its figures."""
    from mjxwalk import zoo
    from mjxwalk.tournament import remarks

    tournaments = {name: zoo.provenance(name).tournament for name in zoo.names()}
    return [(f"{zoo.PREFIX}{name}", remarks.figures(held)) for name, held in tournaments.items()]


def _describe_all(path: Path) -> list[tuple[str, ...]]:
    """Returns a line for a run, and for each run of a study."""
    from mjxwalk.runs import study

    inside = sorted(path.iterdir()) if study.is_study(path) else [path]
    rows = [row for each in inside if (row := _describe(each))]
    return rows if inside == [path] else [(f"{path.name}/{row[0]}", *row[1:]) for row in rows]


def _describe(path: Path) -> tuple[str, ...] | None:
    """Returns a run's name, state, generation and best; None of a folder that is no run."""
    from mjxwalk.cli.progress_text import worth
    from mjxwalk.runs import RunError, config, folder, metrics, result

    if not (path / config.FILE).is_file():
        return None
    try:
        total = config.read_data(path)["experiment"].get("generations", "?")
        lines = metrics.read(path)
        finished = result.read(path)
    except RunError as error:
        return (path.name, "damaged", str(error))
    progress = f"generation {len(lines)} of {total}"
    if finished is not None:
        champion = finished.champion
        best = f"champion {worth(champion)}, falls {champion.fall_rate:.0%}"
        if champion.figures:
            best = ", ".join(f"{name} {value:.2f}" for name, value in champion.figures.items())
        return (path.name, "finished", progress, best)
    state = "running" if folder.is_locked(path) else "stopped"
    distances = [line.best_distance_m for line in lines if line.best_distance_m is not None]
    best = f"best {max(distances):.2f} m" if distances else "-"
    return (path.name, state, progress, best)


def _print_table(rows: list[tuple[str, ...]]) -> None:
    rows = [tuple(map(terminal.one_line, row)) for row in rows]
    widths = [max(map(len, column)) for column in zip(*[row[:-1] for row in rows], strict=False)]
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row[:-1], widths, strict=False)]
        print("  " + "  ".join([*cells, row[-1]]))
