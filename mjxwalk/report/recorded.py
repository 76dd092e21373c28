"""Winners, recorded as they walk on new terrains."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from mjxwalk import replay
from mjxwalk.analysis import angles, gait, trials
from mjxwalk.analysis.angles import AngleDensity
from mjxwalk.analysis.frame import Frame
from mjxwalk.analysis.gait import Gait
from mjxwalk.envs import Planar7, Terrain
from mjxwalk.report.sources import Phase

AT_ONCE = 50  # trials that are recorded together; ours: some 200 MB for 100 s
INTERVAL = 0.5  # s between stick figures; Solomon et al. (2013), Figure 5
SECONDS = 8.0  # of stick figures; ours: as many as a page is wide
CHOICE = 10  # terrains; ours: the stick figures are on the first of them without a fall
# Folded into the seed's key, it leads away from all other keys.
STICK_FIGURES = 0x73746963


class Stick(NamedTuple):
    """A planar walker at several times.

    Attributes:
      label: of the run that it is of.
      seconds: that the figures cover.
      fell: whether it does then.
      skeletons: as `mjxwalk.replay.skeleton` returns them.
      ground_x: where the terrain's nodes are, m.
      ground_z: how high they are, m.
    """

    label: str
    seconds: float
    fell: bool
    skeletons: Float[np.ndarray, "figure 2 7 2"]
    ground_x: Float[np.ndarray, " node"]
    ground_z: Float[np.ndarray, " node"]


class Recorded(NamedTuple):
    """What the winners of a phase do.

    Attributes:
      labels: of the runs.
      gaits: of the winner of each.
      density: of the angles, over all of them.
      stick: the one that falls least.
    """

    labels: tuple[str, ...]
    gaits: tuple[Gait, ...]
    density: AngleDensity
    stick: Stick


def can_be(phase: Phase) -> bool:
    """Returns whether a phase's winner can be recorded: whether it is a planar walker."""
    return isinstance(phase.experiment.env, Planar7)


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
        planar = [phase for phase in phases if can_be(phase)]
        if planar:
            say(f"recording {name}: {num_trials} trials of {len(planar)}")
            found[name] = _record(planar, num_trials, seed, engine)
    return found


def _record(phases: Sequence[Phase], num_trials: int, seed: int, engine: str) -> Recorded:
    gaits: list[Gait] = []
    density = angles.empty_density()
    for phase in phases:
        rows, density = _trials(phase, density, num_trials, seed, engine)
        gaits.append(gait.summarise(rows))
    best = min(range(len(phases)), key=lambda place: _rank(gaits[place]))
    return Recorded(
        labels=tuple(phase.label for phase in phases),
        gaits=tuple(gaits),
        density=density,
        stick=_stick(phases[best], seed, engine),
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
    env = phase.experiment.tried().env
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


def _stick(phase: Phase, seed: int, engine: str) -> Stick:
    """Returns the first seconds of a trial without a fall in them, if there is one."""
    experiment = phase.experiment.tried()
    env = experiment.env
    key = jax.random.fold_in(jax.random.key(seed), STICK_FIGURES)
    heights = np.asarray(experiment.sample_terrains(key, CHOICE))
    terrain: Any = Terrain(heights, np.arange(CHOICE, dtype=np.int32))  # type: ignore[arg-type]
    recording = replay.record(
        env,
        experiment.controller,
        jax.tree.map(
            lambda leaf: np.repeat(np.asarray(leaf)[None], CHOICE, axis=0), phase.walker.genotype
        ),
        terrain,
        duration=SECONDS,
        frames_per_second=1.0 / INTERVAL,
        engine=engine,
    )
    fell = np.asarray(recording.states.fell[-1])
    chosen = int(np.argmin(fell))
    there = ~recording.done[:, chosen]
    ground = env.terrain
    return Stick(
        label=phase.label,
        seconds=float(recording.time[-1, chosen]),
        fell=bool(fell[chosen]),
        skeletons=replay.skeleton(env, recording.states.qpos[there, chosen]),
        ground_x=ground.start + ground.spacing * np.arange(ground.num_nodes),
        ground_z=heights[chosen],
    )
