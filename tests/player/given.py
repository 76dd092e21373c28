"""Recorded walkers of the zoo, pages of them, and a run made up of one of them."""

import dataclasses
import functools
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from mjxwalk import forces, replay, walkers
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.forces import Forces
from mjxwalk.player import page, recording, shown_walkers
from mjxwalk.player.recording import Show, Take
from mjxwalk.player.shown_walkers import ShownWalkers
from mjxwalk.replay import Recording
from mjxwalk.runs import folder
from mjxwalk.runs.checkpoints import Checkpoints
from mjxwalk.runs.trees import flatten

PLANAR, SPATIAL = "zoo:planar-lpd", "zoo:flame-robust"


class Made(NamedTuple):
    """What a page is made of."""

    show: Show
    series: str


@functools.cache
def made(source: str, seconds: float = 3.0) -> Made:
    """Returns the first seconds of a zoo's walker."""
    return Made(*recording.perform(shown(source), Take(seconds=seconds)))


def shown(source: str) -> ShownWalkers:
    """Returns the walker on the ground that it is tried on."""
    found = shown_walkers.best(source)
    return dataclasses.replace(found, experiment=found.experiment.as_tested())


class Recorded(NamedTuple):
    """A walker of the zoo on its ground, frame by frame, and the forces on it."""

    recording: Recording
    forces: Forces
    experiment: Any


def recorded(source: str, frames_per_second: float, seconds: float) -> Recorded:
    """Returns the first seconds of a zoo's walker, as `made` has them."""
    given = shown(source)
    experiment = given.experiment
    env, controller = experiment.env, experiment.controller
    trial = experiment.sample_trials(jax.random.key(0), 1).given(np.zeros(1, np.int32))
    recording = replay.record(
        env,
        controller,
        given.genotypes,
        trial,
        duration=seconds,
        frames_per_second=frames_per_second,
    )
    genotype = jax.tree.map(lambda leaf: leaf[0], given.genotypes)
    felt = forces.measure(env, controller, genotype, trial, recording, 0)
    return Recorded(recording, felt, experiment)


def write_page(path: Path, source: str) -> Path:
    """Writes the page of a zoo's walker."""
    path.write_text(page.render(*made(source)))
    return path


def make_run(path: Path, generations: tuple[int, ...] = (3, 4, 5), elites: int = 2) -> Any:
    """Writes an unfinished run with populations of two planar walkers; returns the genotype.

    In generation g the fittest is the zoo's walker with its blend time set to g; the other is all
    zeros. Of each checkpoint's last generations, the given number of elites is kept.
    """
    walker = walkers.best(PLANAR)
    experiment = walker.experiment
    run_config.create(path, Config(experiment=experiment, seed=0))
    with Checkpoints(path / folder.CHECKPOINTS) as checkpoints:
        for generation in generations:
            best = of_generation(walker.genotype, generation)
            zeros = jax.tree.map(np.zeros_like, best)
            kept = range(generation - elites + 1, generation + 1)
            old = [of_generation(walker.genotype, each) for each in kept]
            arrays = {
                **_named("population", _stacked([zeros, best])),
                **_named("elite", best),
                **_named("elites.genotypes", _stacked(old)),
                "elites.generation": np.array(list(kept), np.int32),
                "fitness": np.array([np.nan, 30.0], np.float32),
            }
            checkpoints.save(generation, arrays)
    return walker.genotype


def of_generation(genotype: Any, generation: int) -> Any:
    """Returns the walker that is told from those of other generations by its blend time."""
    return jax.tree.map(np.asarray, genotype)._replace(blend_time=np.float32(generation))


def _stacked(genotypes: list[Any]) -> Any:
    return jax.tree.map(lambda *leaves: np.stack(leaves), *genotypes)


def _named(prefix: str, tree: Any) -> dict[str, Any]:
    return {f"{prefix}.{name}": leaf for name, leaf in flatten(tree).items()}
