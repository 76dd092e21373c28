"""What was run: settings, versions, time, and how to get the same again."""

from collections.abc import Sequence
from typing import Any

from mjxwalk.experiments import repeating
from mjxwalk.report.parts import Column, Row, RowGroup, Section, Table, cells, frame, number
from mjxwalk.report.sources import Phase, Source


def section(sources: Sequence[Source]) -> Section:
    """Returns the runs, the commands that repeat them, and the versions they ran with."""
    firsts = [source.phases[0] for source in sources]
    commands = [repeating.command(phase.run, phase.experiment) for phase in firsts]
    return Section(
        anchor="provenance",
        title="What was run",
        texts=("To get the same again, in folders of their own:",),
        commands=tuple(dict.fromkeys(commands)),
        parts=(_runs(sources), _versions(sources)),
    )


def state(phase: Phase) -> str:
    """Returns how far a run came, in words."""
    done = len(phase.run.metrics["generation"])
    if phase.is_finished:
        return "finished"
    planned = phase.experiment.generations
    return f"{'running' if phase.is_running else 'cut short'} at {done} of {planned}"


def wall_time(phase: Phase) -> float:
    """Returns the wall time of all generations, over every resume, s."""
    return sum(
        float(phase.run.metrics[name].sum()) for name in ("evaluate_s", "compile_s", "other_s")
    )


def duration(seconds: float) -> str:
    """Returns a time in words."""
    hours, rest = divmod(round(seconds), 3600)
    minutes, rest = divmod(rest, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {rest} s" if minutes else f"{seconds:.1f} s"


def _runs(sources: Sequence[Source]) -> Table:
    phases = [phase for source in sources for phase in source.phases]
    titles = ("experiment", "seed", "population", "generations", "state", "engine", "wall time")
    return Table(
        name="runs",
        caption="The runs",
        head="folder",
        columns=tuple(Column(title) for title in (*titles, "physics steps (million)")),
        groups=(RowGroup("", tuple(_run(phase) for phase in phases)),),
        data=frame([_numbers(phase) for phase in phases]),
        note="Wall time is that of all generations, without the tournaments.",
    )


def _run(phase: Phase) -> Row:
    return Row(
        phase.label,
        cells(
            phase.experiment.name,
            str(phase.seed),
            str(phase.experiment.population_size),
            f"{len(phase.run.metrics['generation']):,}",
            state(phase),
            _engine(phase),
            duration(wall_time(phase)),
            number(_steps(phase) / 1e6, 1),
        ),
    )


def _numbers(phase: Phase) -> dict[str, Any]:
    return {
        "folder": phase.label,
        "experiment": phase.experiment.name,
        "seed": phase.seed,
        "population_size": phase.experiment.population_size,
        "generations": len(phase.run.metrics["generation"]),
        "generations_at_most": phase.experiment.generations,
        "finished": phase.is_finished,
        "engine": _engine(phase),
        "wall_s": wall_time(phase),
        "physics_steps": _steps(phase),
    }


def _steps(phase: Phase) -> int:
    return int(phase.run.metrics["physics_steps"].sum())


def _engine(phase: Phase) -> str:
    return str(phase.run.manifest.get("engine", phase.run.config["engine"]))


def _versions(sources: Sequence[Source]) -> Table:
    manifests = [phase.run.manifest for source in sources for phase in source.phases]
    found = {
        "mjxwalk": _values(manifests, "mjxwalk"),
        "commit": _values(manifests, "commit"),
        "Python": _values(manifests, "python"),
    }
    packages = [manifest.get("packages") or {} for manifest in manifests]
    for package in dict.fromkeys(name for each in packages for name in each):
        found[package] = _values(packages, package)
    for title, name in (("devices", "devices"), ("processor", "cpu"), ("system", "system")):
        found[title] = _values(manifests, name)
    rows = tuple(Row(title, cells("; ".join(values))) for title, values in found.items())
    return Table(
        name="versions",
        caption="Versions and machines",
        head="of",
        columns=(Column("version or name"),),
        groups=(RowGroup("", rows),),
        data=frame([{"of": k, "value": "; ".join(values)} for k, values in found.items()]),
        note="A commit with a plus had changes that were not committed.",
    )


def _values(tables: Sequence[dict[str, Any]], name: str) -> list[str]:
    """Returns the different values that the runs have."""
    return list(dict.fromkeys(str(table.get(name) or "not known") for table in tables))
