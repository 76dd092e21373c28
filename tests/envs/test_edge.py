"""Tests of what callers may give bodies and controllers: NumPy arrays and lists."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import experiments
from mjxwalk.envs import Terrain, Trial, Trials, edge
from mjxwalk.evaluation import Evaluator

NAMES = ("planar-lpd", "solomon-3d", "reil-unassisted", "rayleigh-walk")
every_walker = pytest.mark.parametrize("name", NAMES)


class Heaviest:
    """A task whose fitness is a weight, found on the first node of its terrain."""

    def rollout(self, genotype: Any, given: Trial) -> Any:
        return genotype * given.ground.heights[given.ground.row, 0]


def _listed(tree: Any) -> Any:
    return jax.tree.map(lambda leaf: np.asarray(leaf).tolist(), tree)


def _numpy(tree: Any) -> Any:
    return jax.tree.map(lambda leaf: np.asarray(leaf, _double(leaf)), tree)


def _double(leaf: Any) -> Any:
    return np.float64 if jnp.issubdtype(leaf.dtype, jnp.floating) else leaf.dtype


@every_walker
@pytest.mark.usefixtures("unchecked_types")
@pytest.mark.parametrize("given", [_numpy, _listed], ids=["NumPy float64", "lists"])
def test_numpy_arrays_and_lists_are_taken_everywhere(name: str, given: Any) -> None:
    experiment = experiments.get(name)
    env, controller = experiment.env, experiment.controller
    genotype = jax.tree.map(
        lambda leaf: np.full(leaf.shape, 0.1, np.float32), controller.template()
    )
    trials = jax.tree.map(np.asarray, env.sample_trials(jax.random.key(0), 2))

    def walk(taken: Any) -> Any:
        """Returns a step of the walker, each part of which gets what `taken` makes of it."""
        trial = jax.tree.map(taken, trials.given(np.asarray(1)))
        state = env.reset(trial)
        seen, memory = env.observe(taken(_zeros(state))), controller.init(taken(genotype))
        after, action = controller.act(taken(genotype), taken(_zeros(memory)), taken(_zeros(seen)))
        stepped = env.step(taken(_zeros(state)), taken(_zeros(action)), trial)
        return state, seen, memory, after, action, stepped

    # Nothing is computed: what was not converted fails as it is traced.
    assert jax.eval_shape(lambda: walk(given)) == jax.eval_shape(lambda: walk(lambda tree: tree))


def _zeros(tree: Any) -> Any:
    return jax.tree.map(lambda leaf: np.zeros(leaf.shape, leaf.dtype), tree)


def test_numbers_stay_what_they_are() -> None:
    got = edge.as_arrays(Terrain([[1.5, -2.0]], 1))  # type: ignore[arg-type]
    np.testing.assert_array_equal(got.heights, [[1.5, -2.0]])
    assert got.heights.dtype == jnp.float32 and got.row == 1


@every_walker
@pytest.mark.usefixtures("unchecked_types")
def test_ground_and_weights_of_other_shapes_are_refused(name: str) -> None:
    experiment = experiments.get(name)
    env, controller = experiment.env, experiment.controller
    heights = env.level_trials(2).heights
    fewer = heights.shape[1] - 1
    wrong: list[tuple[Any, Any, str]] = [
        (heights[0], 0, r"heights must have shape \(terrains, "),
        (heights[:, :fewer], 0, rf"shape \(terrains, .* at least, got \(2, {fewer}[,)]"),
        (heights[:0], 0, r"heights must have shape"),
        (heights, 2, "row must be from 0 to 1, got 2"),
        (heights, 0.0, "row must be one whole number, got float32"),
        (heights, [0], r"row must be one whole number, got int32 of shape \(1,\)"),
    ]
    for table, row, message in wrong:
        with pytest.raises(ValueError, match=message):
            env.reset(Trial(Terrain(table, row)))
    few: Any = np.zeros(len(env.START_DEPARTURES) - 1)
    row: Any = 0
    with pytest.raises(ValueError, match=r"start must have shape \(\d,\), got"):
        env.reset(Trial(Terrain(heights, row), few))
    template = jax.tree.map(np.asarray, controller.template())
    short = jax.tree.map(lambda leaf: leaf.reshape(-1)[:1], template)
    with pytest.raises(ValueError, match=r"genotype.* must have shape .*, got \(1,\)"):
        controller.init(short)


def test_what_is_no_array_stays_as_it_is() -> None:
    axes: Any = Terrain(None, 0)  # type: ignore[arg-type]
    assert edge.as_arrays(axes).heights is None


@pytest.mark.usefixtures("unchecked_types")
def test_a_population_may_be_of_any_numbers() -> None:
    evaluator = Evaluator(Heaviest(), "mjx")
    expected = [[1.0, 10.0], [2.0, 20.0]]
    for population in (np.array([1.0, 2.0]), np.array([1, 2], np.int8), jnp.array([1.0, 2.0])):
        for heights in (np.array([[1.0], [10.0]]), [[1.0], [10.0]]):
            got: Any = evaluator.evaluate(population, Trials(heights))
            np.testing.assert_array_equal(got, expected)
            assert got.dtype == np.float32
    with pytest.raises(ValueError, match="population must have genotypes in front of all leaves"):
        evaluator.evaluate((np.ones(2), np.ones(3)), Trials(np.ones((1, 1))))
    with pytest.raises(ValueError, match="population must have genotypes in front of all leaves"):
        evaluator.evaluate(1.0, Trials(np.ones((1, 1))))
    with pytest.raises(ValueError, match="trials must have trials in front of all leaves"):
        evaluator.evaluate(np.ones(2), Trials(np.ones((0, 4))))
    with pytest.raises(ValueError, match="trials must have trials in front of all leaves"):
        evaluator.evaluate(np.ones(2), Trials(np.ones((3, 4)), start=np.ones((2, 3))))
