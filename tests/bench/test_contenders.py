"""Tests of the contenders with few walkers; nothing is said of their speed."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.bench import bodies, c_contenders, contenders
from mjxwalk.bench.bodies import PointBody
from mjxwalk.bench.evolved import Evolved
from mjxwalk.bench.peak import Peak
from mjxwalk.bench.workload import Workload
from mjxwalk.engines import lanes, lanes_xla, mjx
from mjxwalk.envs import TRIAL_AXES, Terrain, Trial
from mjxwalk.experiments.experiment import Experiment
from mjxwalk.rollout import Outcome


def points(name: str) -> PointBody:
    """Returns a body under our contact points."""
    body = bodies.get(name)
    assert isinstance(body, PointBody)
    return body


PLANAR = points("planar7-points")
STUDY = dataclasses.replace(PLANAR.study(), population_size=8)
LONG = c_contenders.LONGEST_ROLLOUT + 7  # more than one part


def start(genotype: Any, given: Trial) -> Any:
    """Returns a point mass on the ground."""
    return given.ground.heights[given.ground.row, 0] + 0.0 * genotype


def advance(genotype: Any, given: Trial, height: Any) -> Any:
    """Returns it a little higher."""
    del given
    return height + genotype


def climbers(size: int) -> Workload:
    rows: Any = np.zeros(size, np.int32)
    trials = Trial(Terrain(np.ones((1, 3), np.float32), rows))  # type: ignore[arg-type]
    genotypes = np.arange(size, dtype=np.float32)
    return Workload(start, advance, genotypes, trials, (0, TRIAL_AXES))


@pytest.fixture(scope="module")
def walking() -> contenders.Engine:
    return contenders.Engine(lanes.vmap, PLANAR.workload(4))


@pytest.mark.parametrize("steps", [1, 3, LONG])
def test_every_contender_takes_the_same_steps(steps: int) -> None:
    rivals = {
        "lanes": contenders.Engine(lanes.vmap, climbers(5)),
        "lanes_xla": contenders.Engine(lanes_xla.vmap, climbers(5)),
        "mjx": contenders.Engine(mjx.vmap, climbers(5)),
        **{name: make() for name, make in c_contenders.of_points(PLANAR, 5, 2).items()},
    }
    assert {name: rival(steps) for name, rival in rivals.items()} == dict.fromkeys(
        rivals, 5 * steps
    )


def test_the_steps_are_taken_and_not_only_counted() -> None:
    population = climbers(5)
    for vmap in (lanes.vmap, lanes_xla.vmap, mjx.vmap):
        engine = contenders.Engine(vmap, population)
        walked = engine.mapped(population.genotypes, population.given, np.int32(6))
        np.testing.assert_array_equal(walked.walk, 1 + 6 * np.arange(5))


@pytest.mark.slow
def test_the_spatial_body_walks_and_is_not_torn_apart() -> None:
    population = points("flame-points").workload(64)
    engine = contenders.Engine(lanes.vmap, population)
    walked = engine.mapped(population.genotypes, population.given, np.int32(200))
    state = walked.walk.state
    assert not state.trial.diverged.any() and state.trial.num_steps.tolist() == [200] * 64
    assert np.ptp(state.qpos[:, 0]) > 0.01  # the weights matter


@pytest.mark.slow
def test_walkers_that_fall_go_on_to_the_last_step(walking: contenders.Engine) -> None:
    population = PLANAR.workload(4)
    # Without a gait they fall within a second.
    walked = walking.mapped(population.genotypes, population.given, np.int32(2000))
    assert walked.walk.state.trial.done.all()
    assert walked.walk.state.trial.num_steps.tolist() == [2000] * 4
    assert walking(2000) == 8000


def test_a_compiled_walker_is_found_on_the_disk_again() -> None:
    contenders.Engine(lanes.vmap, climbers(5))(1)
    again = contenders.Engine(lanes.vmap, climbers(7))
    again(1)
    assert again.mapped.compiled.cached


class Counting(Experiment):
    """Walkers that fall after seven steps, on the first terrain after eight."""

    def rollout(self, genotype: Any, given: Trial) -> Outcome:
        """Returns what one walker does in one trial."""
        far = genotype.walking.sum()
        fell, steps = far < 0, jnp.where(given.ground.row == 0, 8, 7)
        return Outcome(far, far, far, fell, fell, far, far, steps)


def test_an_evolved_population_counts_the_steps_of_its_trials() -> None:
    study = dataclasses.replace(Counting(**vars(STUDY)), terrains_per_evaluation=3)
    evolved = Evolved(study, generations=2)
    assert evolved.size == 8 * 3
    assert evolved(1) == 2 * 8 * (8 + 7 + 7)
    assert evolved(3) == 3 * evolved(1)
    assert 0 < evolved.lane_utilisation <= 1


@pytest.mark.parametrize("width", [4, 8])
def test_the_peak_counts_the_operations_of_its_vectors(width: int) -> None:
    peak = Peak(threads=2, width=width)
    assert peak(1) == 1000 * peak.chains * width * 2 * 2


def test_walkers_differ_in_their_weights_and_share_the_ground() -> None:
    population = PLANAR.workload(3)
    leaf = jax.tree.leaves(population.genotypes)[0]
    assert leaf.shape[0] == 3 and len(np.unique(leaf.reshape(3, -1), axis=0)) == 3
    assert population.given.ground.heights.shape[0] == 1
    assert population.given.ground.row.tolist() == [0, 0, 0]
