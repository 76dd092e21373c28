"""What a reader has to know before believing a report: what is missing, short, or doubtful."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mjxwalk import shell
from mjxwalk.analysis import paper
from mjxwalk.report.parts import Remark
from mjxwalk.report.provenance_section import state
from mjxwalk.report.sources import Phase, Source, shown
from mjxwalk.report.sources import is_paper as is_of_paper
from mjxwalk.tournament import remarks
from mjxwalk.tournament.results import (
    AS_EVOLVED,
    HALF_STEP,
    PAPERS_STEP,
    PERTURBED,
    Condition,
    Tournament,
)

LISTED = 4  # runs that are named; of more it is told how many
PLACES = {
    HALF_STEP: f"at {HALF_STEP}",
    PAPERS_STEP: f"at {PAPERS_STEP}",
    PERTURBED: f"from {PERTURBED}",
}
Items = tuple[tuple[str, str], ...]


def find(sources: Sequence[Source], variants: Mapping[str, Sequence[Phase]]) -> list[Remark]:
    """Returns what there is to say, the gravest first."""
    phases = [phase for source in sources for phase in source.phases]
    told: list[tuple[str, Items]] = [
        (
            "Runs that did not come to their end; averages take what there is:",
            _cut(phases),
        ),
        ("Studies with phases that have not begun:", _missing(sources)),
        ("Checkpoints that are damaged and were passed over:", _damaged(phases)),
        ("Removing links was still going on as the generations were over:", _unpruned(phases)),
        ("No tournament has told how good these are; hold one:", _untried(phases)),
        ("What the tournaments found:", _gaits(phases)),
        ("The same run more than once, so that deviations are too small:", _twins(variants)),
        ("Runs of different origin that are averaged all the same:", _mixed(variants)),
        ("Scaled down, so that only the structure is that of the study:", _scaled(sources)),
    ]
    found = [Remark(text, items) for text, items in told if items]
    if max(map(len, variants.values())) == 1:
        one = "One run of each phase: nothing here tells how much runs differ."
        is_paper = is_of_paper(variants)
        found.append(Remark(f"{one} The paper averages {paper.RUNS}." if is_paper else one))
    return found


def _command(name: str, folder: str) -> str:
    return shell.command(name, Path(folder))


def _cut(phases: Sequence[Phase]) -> Items:
    return tuple(
        (f"{phase.label}: {state(phase)}", _command("resume", _root(phase)))
        for phase in phases
        if not phase.is_finished
    )


def _root(phase: Phase) -> str:
    """Returns the folder to resume: the study's, if the run is in one."""
    parent = phase.run.path.parent
    return shown(parent if (parent / "study.json").is_file() else phase.run.path)


def _missing(sources: Sequence[Source]) -> Items:
    return tuple(
        (f"{source.label}: {', '.join(source.missing)}", _command("resume", source.label))
        for source in sources
        if source.missing
    )


def _damaged(phases: Sequence[Phase]) -> Items:
    return tuple(
        (f"{phase.label}: generation {generation}, {reason}", "")
        for phase in phases
        for generation, reason in phase.run.damaged.items()
    )


def _unpruned(phases: Sequence[Phase]) -> Items:
    return tuple(
        (phase.label, "")
        for phase in phases
        if phase.is_finished and not phase.run.strategy_state.get("finished", True)
    )


def _untried(phases: Sequence[Phase]) -> Items:
    return tuple(
        ("", _command("tournament", phase.label))
        for phase in phases
        if phase.tournament is None and not phase.is_between
    )


def _gaits(phases: Sequence[Phase]) -> Items:
    tried = [(phase, phase.tournament) for phase in phases if phase.tournament is not None]
    if len(tried) > LISTED:
        return tuple(
            (f"{name}, {line}", "")
            for name in dict.fromkeys(phase.name for phase, _ in tried)
            for line in _counted([held for phase, held in tried if phase.name == name])
        )
    found: dict[str, list[str]] = {}
    for phase, held in tried:
        for remark in remarks.remarks(held):
            found.setdefault(remark, []).append(phase.label)
    return tuple((f"{_listed(labels)}: {remark}", "") for remark, labels in found.items())


def _counted(held: Sequence[Tournament]) -> list[str]:
    """Returns how many of a phase's winners walk otherwise than as they evolved, and how often."""
    usual = [each.condition(AS_EVOLVED) for each in held]
    lines: list[str] = []
    for name, place in PLACES.items():
        tried = [each.condition(name) for each in held]
        apart = sum(name in remarks.otherwise(each) for each in held)
        if apart:
            lines.append(
                f"{apart} of {len(held)} winners: another gait {place}, where {_range(tried)} "
                f"fall in place of {_range(usual)}"
            )
    return lines


def _range(conditions: Sequence[Condition | None]) -> str:
    rates = [100 * each.fall_rate for each in conditions if each is not None]
    return f"{min(rates):.1f} to {max(rates):.1f} %"


def _listed(labels: Sequence[str]) -> str:
    return ", ".join(labels) if len(labels) <= LISTED else f"{len(labels)} runs"


def _twins(variants: Mapping[str, Sequence[Phase]]) -> Items:
    found: list[tuple[str, str]] = []
    for phases in variants.values():
        first: dict[Any, Phase] = {}
        for phase in phases:
            fitness = phase.run.metrics["best_fitness"].tobytes()
            other = first.setdefault((phase.seed, fitness), phase)
            if other is not phase:
                found.append((f"{other.label} and {phase.label}: seed {phase.seed}", ""))
    return tuple(found)


def _mixed(variants: Mapping[str, Sequence[Phase]]) -> Items:
    found: list[tuple[str, str]] = []
    for name, phases in variants.items():
        for title, key in (("engines", "engine"), ("versions", "mjxwalk"), ("commits", "commit")):
            values = {str(phase.run.manifest.get(key)) for phase in phases}
            if len(values) > 1:
                found.append((f"{name}: {title} {', '.join(sorted(values))}", ""))
    return tuple(found)


def _scaled(sources: Sequence[Source]) -> Items:
    return tuple(
        (f"{source.label}: by {source.study.scale:g}", "")
        for source in sources
        if source.study is not None and source.study.scale != 1.0
    )
