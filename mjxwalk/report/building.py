"""Puts a report together."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from mjxwalk.analysis import style
from mjxwalk.engines.pinning import pinned
from mjxwalk.report import (
    benchmarks,
    fitness,
    fits,
    hips,
    links,
    networks,
    provenance_section,
    recorded,
    remarks,
    replayed,
    sources,
    walking,
    winners,
)
from mjxwalk.report.parts import Page, Section, count, number, percent
from mjxwalk.report.sources import Phase, Source

PAPER = (
    'The paper: Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and '
    '3D bipedal walking over rough terrain", Adaptive Behavior 21(1), doi '
    "10.1177/1059712312462904. The bodies of its tables cannot be had; what its text tells stands "
    "here, and the rest is lost."
)
ADULTS = (
    'Adults: Fukuchi, Fukuchi & Duarte (2018), "A public dataset of overground and treadmill '
    'walking kinematics and kinetics in healthy individuals", PeerJ 6:e4640, data at doi '
    "10.6084/m9.figshare.5722711, CC BY 4.0."
)


@pinned()
@style.own()
def build(
    paths: Sequence[Path],
    *,
    num_trials: int,
    seed: int,
    engine: str,
    say: Callable[[str], None],
) -> Page:
    """Returns the page on some folders.

    Args:
      paths: of runs and studies, at least one.
      num_trials: of each winner that is recorded; 0 to record none.
      seed: of their terrains.
      engine: that runs the trials.
      say: is told what begins.

    Raises:
      RunError: a folder cannot be read, or the runs cannot be averaged.
      ValueError: there is no such engine.
    """
    read = [sources.read(path) for path in paths]
    if any(map(fits.is_fit, read)):
        return fits.build(read)
    variants = sources.by_variant(read)
    asked = {name: each for name, each in variants.items() if not each[0].is_between}
    if any(map(hips.is_hip_powered, read)):
        sections = hips.sections(variants, num_trials=num_trials, engine=engine, say=say)
        references = hips.REFERENCES
    else:
        sections = _sections(
            variants, asked, num_trials=num_trials, seed=seed, engine=engine, say=say
        )
        references = _references(asked, has_gaits=num_trials > 0)
    return Page(
        title=_title(read),
        lead=_lead(read, asked),
        remarks=tuple(remarks.find(read, variants)),
        sections=(provenance_section.section(read), *sections),
        references=references,
    )


def _sections(
    variants: Mapping[str, Sequence[Phase]],
    asked: Mapping[str, Sequence[Phase]],
    *,
    num_trials: int,
    seed: int,
    engine: str,
    say: Callable[[str], None],
) -> tuple[Section, ...]:
    """Returns what there is to tell of walkers, beside the paper's where they have its body.

    Args:
      variants: by phase, in their order.
      asked: those of them whose walkers are asked for.
      num_trials: 0 to record none.
      seed: of the trials.
      engine: that runs them.
      say: is told what begins.
    """
    found: dict[str, recorded.Recorded] = {}
    if num_trials:
        found = recorded.record(asked, num_trials=num_trials, seed=seed, engine=engine, say=say)
    why_not = (
        recorded.why_not([phase for phases in asked.values() for phase in phases])
        if num_trials
        else "Tables and figures of the gait were left out; --trials 100 makes them."
    )
    replay = replayed.section(asked, found, seed=seed, say=say) if num_trials else None
    left = networks.section(asked)
    return (
        *([replay] if replay else []),
        fitness.section(variants),
        winners.section(asked),
        benchmarks.section(asked),
        *([links.section(asked)] if sources.is_paper(asked) else []),
        *([left] if left else []),
        walking.section(found, why_not=why_not),
    )


def _references(asked: Mapping[str, Sequence[Phase]], *, has_gaits: bool) -> tuple[str, ...]:
    """Returns where the numbers of others on the page are from."""
    if sources.is_paper(asked):
        return (PAPER, ADULTS)
    phases = [phase for given in asked.values() for phase in given]
    return (ADULTS,) if has_gaits and any(map(recorded.is_beside_adults, phases)) else ()


def _title(read: Sequence[Source]) -> str:
    names = list(dict.fromkeys(source.name for source in read))
    first = read[0].phases[0]
    body = "" if first.is_paper else first.body
    return f"{' and '.join(names)}{f', {body}' if body else ''}, {count(len(read), 'run')}"


def _lead(read: Sequence[Source], variants: Mapping[str, Sequence[Phase]]) -> tuple[str, ...]:
    """Returns what was run and what came out, a sentence for each phase."""
    phases = [phase for source in read for phase in source.phases]
    steps = sum(int(phase.run.metrics["physics_steps"].sum()) for phase in phases)
    generations = sum(len(phase.run.metrics["generation"]) for phase in phases)
    wall = provenance_section.duration(sum(map(provenance_section.wall_time, phases)))
    told = [
        f"{count(generations, 'generation')} and {number(steps / 1e6, 1)} million physics steps in "
        f"{wall}."
    ]
    for name, given in variants.items():
        usual = [each for each in map(winners.usual, given) if each is not None]
        if usual:
            tried = winners.gathered(usual)
            one = len(usual) == 1
            who = "the winner walks" if one else f"{len(usual)} winners walk"
            falls = percent(tried.falls / tried.trials)
            told.append(
                f"{name}: {who} {number(tried.distance.mean, 1)} m on average and "
                f"{'falls' if one else 'fall'} in {falls} of {count(tried.trials, 'trial')}, at a "
                f"cost of transport of {number(tried.figures['cost_of_transport'].mean, 2)}."
            )
    return tuple(told)
