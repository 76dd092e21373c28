"""Rollouts of bodies of every kind, and the shapes of their arguments."""

import functools
from typing import Any

import jax
import numpy as np

from mjxwalk import experiments, robots
from mjxwalk.envs.mjcf import reader
from mjxwalk.experiments import walk


def of_file(name: str, law: str) -> Any:
    """Returns the experiment of a body that ships as a file, under a contact law."""
    return walk.with_contact(walk.of_body(reader.read(robots.path(name)).text), law)


BODIES: dict[str, Any] = {
    "planar7": functools.partial(experiments.get, "planar-lpd"),
    "flame": functools.partial(experiments.get, "solomon-3d"),
    "reil": functools.partial(experiments.get, "reil-unassisted"),
    "walker2d, points": functools.partial(of_file, "walker2d", "points"),
    "walker2d, mujoco": functools.partial(of_file, "walker2d", "mujoco"),
    "h1, points": functools.partial(of_file, "h1", "points"),
    "op3, mujoco": functools.partial(of_file, "op3", "mujoco"),
    "Hopper-v5": functools.partial(experiments.get, "gymnasium/Hopper-v5"),
    "Humanoid-v5": functools.partial(experiments.get, "gymnasium/Humanoid-v5"),
}


def shapes(experiment: Any, walkers: int) -> tuple[Any, Any]:
    """Returns a population without numbers, and its trials."""
    trials = experiment.sample_trials(jax.random.key(0), 2).given(np.zeros(walkers, np.int32))
    population = jax.tree.map(
        lambda leaf: jax.ShapeDtypeStruct((walkers, *leaf.shape), leaf.dtype), experiment.template()
    )
    return population, trials
