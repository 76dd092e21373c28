"""Winners, recorded as they walk on new terrains."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import jax
import numpy as np

from mjxwalk import replay
from mjxwalk.analysis import angles, faults, gait, roles, sticks, trials
from mjxwalk.analysis.angles import AngleDensity
from mjxwalk.analysis.frame import Frame
from mjxwalk.analysis.gait import Gait
from mjxwalk.analysis.sticks import Sticks
from mjxwalk.envs.anatomy import anatomy_of, is_spatial
from mjxwalk.report.sources import Phase

AT_ONCE = 50  # trials that are recorded together; ours: some 200 MB for 100 s
LOOKED_AT = 10  # trials whose frames are searched for faults; ours: MuJoCo takes a second for each
INTERVAL = 0.5  # s between stick figures; Solomon et al. (2013), Figure 5
SECONDS = 8.0  # of stick figures; ours: as many as a page is wide
ADULT_LEGS = (0.7, 1.2)  # m, from the root down; ours: shorter and longer ones walk otherwise
CHOICE = 10  # terrains; ours: the stick figures are on the first of them without a fall
# Folded into the seed's key, it leads away from all other keys.
STICK_FIGURES = 0x73746963


class Stick(NamedTuple):
    """A walker at several times.

    Attributes:
      label: of the run that it is of.
      seconds: that the figures cover.
      fell: whether it does then.
      sticks: the figures.
    """

    label: str
    seconds: float
    fell: bool
    sticks: Sticks


class Recorded(NamedTuple):
    """What the winners of a phase do.

    Attributes:
      labels: of the runs.
      gaits: of the winner of each.
      density: of the angles, over all of them.
      stick: the one that falls least.
      faults: of each in some trials, from `analysis.faults`; None of planar walkers.
      is_paper: whether they walk with a body of the paper.
      is_beside_adults: whether adults' numbers say something of them.
    """

    labels: tuple[str, ...]
    gaits: tuple[Gait, ...]
    density: AngleDensity
    stick: Stick
    faults: Frame | None
    is_paper: bool
    is_beside_adults: bool = True


def is_beside_adults(phase: Phase) -> bool:
    """Returns whether a phase's body has two feet with roles, and legs about as long as adults'."""
    length = getattr(phase.experiment.env, "leg_length", 0.0)
    return can_be(phase) and ADULT_LEGS[0] <= length <= ADULT_LEGS[1]


def can_be(phase: Phase) -> bool:
    """Returns whether a phase's winner can be recorded: whether its two legs have roles."""
    return roles.roles_of(phase.experiment.env) is not None


def why_not(phases: Sequence[Phase]) -> str:
    """Returns why the winners of phases cannot be recorded."""
    known = [anatomy_of(phase.experiment.env) for phase in phases]
    for anatomy in known:
        if anatomy is not None and len(anatomy.legs) != 2:
            return (
                f"Gait, strides and angles are told of bodies on two feet, and {anatomy.name} has "
                f"{len(anatomy.legs)} legs."
            )
    return "Gaits are told of bodies on two feet with hips, knees and ankles of their own."


def record(
    variants: Mapping[str, Sequence[Phase]],
    *,
    num_trials: int,
    seed: int,
    engine: str,
    say: Callable[[str], None],
) -> dict[str, Recorded]:
    """Returns, by phase, what the winners do, each in trials of its own.

    Args:
      variants: those of `sources.by_variant`; phases whose winner cannot be recorded are left out.
      num_trials: of each winner, at least 1.
      seed: of the terrains.
      engine: that runs the trials.
      say: is told what begins.
    """
    found: dict[str, Recorded] = {}
    for name, phases in variants.items():
        recordable = [phase for phase in phases if can_be(phase)]
        if recordable:
            say(f"recording {name}: {num_trials} trials of {len(recordable)}")
            found[name] = _record(recordable, num_trials, seed, engine)
    return found


def _record(phases: Sequence[Phase], num_trials: int, seed: int, engine: str) -> Recorded:
    gaits: list[Gait] = []
    known = roles.roles_of(phases[0].experiment.env) or roles.PLANAR
    density = angles.empty_density(known)
    for phase in phases:
        rows, density = _trials(phase, density, num_trials, seed, engine)
        gaits.append(gait.summarise(rows))
    best = min(range(len(phases)), key=lambda place: _rank(gaits[place]))
    return Recorded(
        labels=tuple(phase.label for phase in phases),
        gaits=tuple(gaits),
        density=density,
        stick=_stick(phases[best], seed, engine),
        faults=_faults(phases, seed, engine),
        is_paper=known.is_paper,
        is_beside_adults=known.is_paper or is_beside_adults(phases[0]),
    )


def _rank(measured: Gait) -> tuple[int, float]:
    """Returns what is lowest for the walker that falls least, and costs least of such."""
    cost = measured.cost_of_transport.mean
    return measured.falls, cost if np.isfinite(cost) else np.inf


def _trials(
    phase: Phase, density: AngleDensity, num_trials: int, seed: int, engine: str
) -> tuple[Frame, AngleDensity]:
    """Returns a row for each trial, and the density with their steps added."""
    import pandas as pd

    rows: list[Any] = []
    env = phase.experiment.as_tested().env
    for place, first in enumerate(range(0, num_trials, AT_ONCE)):
        recording = trials.record_trials(
            phase.experiment,
            phase.walker.genotype,
            trials=min(AT_ONCE, num_trials - first),
            seed=seed + place,
            engine=engine,
        )
        rows.append(gait.measure_trials(recording, env))
        steps = angles.step_angles(recording, env)
        density = angles.add_steps(density, steps)
    return pd.concat(rows, ignore_index=True), density


def _faults(phases: Sequence[Phase], seed: int, engine: str) -> Frame | None:
    """Returns what the gaits of spatial walkers hide, a row for each."""
    import pandas as pd

    if not is_spatial(phases[0].experiment.env):
        return None
    rows: list[Any] = []
    for phase in phases:
        experiment = phase.experiment.as_tested()
        recording = trials.record_trials(
            experiment, phase.walker.genotype, trials=LOOKED_AT, seed=seed, engine=engine
        )
        measured = faults.measure_faults(recording, experiment.env)
        rows.append(measured[list(faults.FAULTS)].abs().mean())
    return pd.DataFrame(rows, index=[phase.label for phase in phases])


def _stick(phase: Phase, seed: int, engine: str) -> Stick:
    """Returns the first seconds of a trial without a fall in them, if there is one."""
    experiment = phase.experiment.as_tested()
    env = experiment.env
    key = jax.random.fold_in(jax.random.key(seed), STICK_FIGURES)
    trials_given = experiment.sample_trials(key, CHOICE)
    recording = replay.record(
        env,
        experiment.controller,
        jax.tree.map(
            lambda leaf: np.repeat(np.asarray(leaf)[None], CHOICE, axis=0), phase.walker.genotype
        ),
        trials_given.given(np.arange(CHOICE, dtype=np.int32)),
        duration=SECONDS,
        frames_per_second=1.0 / INTERVAL,
        engine=engine,
    )
    fell = np.asarray(recording.states.trial.fell[-1])
    chosen = int(np.argmin(fell))
    there = ~recording.done[:, chosen]
    return Stick(
        label=phase.label,
        seconds=float(recording.time[-1, chosen]),
        fell=bool(fell[chosen]),
        sticks=sticks.find(
            env, recording.states.qpos[there, chosen], trials_given.given(chosen).ground
        ),
    )
