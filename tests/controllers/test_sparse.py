"""Networks that begin with a share of their links: which, how many, and always the same."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import robots
from mjxwalk.controllers import PatternGenerator, sparse
from mjxwalk.envs import MjcfEnv
from mjxwalk.runs.trees import flatten

ENV = MjcfEnv.of(robots.text("walker2d"))
NONE = np.zeros((4, 5), bool)


def generator(**settings: Any) -> Any:
    return PatternGenerator(neurons=20, **settings).on(ENV)


def test_the_same_seed_draws_the_same_links_for_ever() -> None:
    # Stored runs do not hold their links, only the seed: these must never be others.
    there = sparse.drawn(0.3, 7, 0, NONE)
    assert np.flatnonzero(there).tolist() == [2, 3, 4, 10, 14, 17]
    assert np.array_equal(sparse.drawn(0.3, 7, 0, NONE), there)
    assert not np.array_equal(sparse.drawn(0.3, 8, 0, NONE), there)
    assert not np.array_equal(sparse.drawn(0.3, 7, 1, NONE), there)


def test_every_link_is_as_likely_as_any_other() -> None:
    drawn = np.mean([sparse.drawn(0.25, seed, 0, NONE) for seed in range(2000)], axis=0)
    # Of 2,000 draws a share of 0.25 has a standard error of 0.0097.
    assert np.all(np.abs(drawn - 0.25) < 0.04)


def test_links_that_are_kept_are_there_and_count() -> None:
    kept = NONE.copy()
    kept[0, :3] = True
    for density, num in ((0.01, 3), (0.2, 4), (1.0, 20)):
        there = sparse.drawn(density, 3, 0, kept)
        assert there.sum() == num and there[0, :3].all()


def test_a_generator_of_a_density_has_so_many_links_and_lifts_its_legs_as_the_whole_one() -> None:
    whole, thin = generator(), generator(density=0.1)
    there = flatten(thin.present())
    assert [int(there[leaf].sum()) for leaf in ("weights", "crossed")] == [40, 40]
    assert int(there["senses"].sum()) == round(2.0 * len(thin.layout.inputs))
    assert there["motors"].all() and there["weights"][:2, :2].all() and there["crossed"][0, 0]
    assert all(leaf.all() for leaf in flatten(whole.present()).values())
    for name, leaf in flatten(thin.template()).items():
        assert not np.any(np.asarray(leaf)[~there[name]]), name
    numbers = flatten(thin.prunable())
    assert all(np.array_equal(numbers[leaf] >= 0, there[leaf]) for leaf in ("weights", "senses"))
    assert len([row for row in thin.weight_table(thin.template()) if row[0] == "weights"]) == 40


def test_what_is_not_there_is_no_dimension_of_the_search() -> None:
    thin = generator(density=0.1, feels=False)
    assert not flatten(thin.mask())["senses"].any()
    assert jax.tree.structure(thin.mask()) == jax.tree.structure(thin.template())
    alone = dataclasses.replace(thin, layout=dataclasses.replace(thin.layout, input_mirror=()))
    assert not flatten(alone.mask())["crossed"].any()
    assert jnp.asarray(alone.mask().weights).sum() == 40


@pytest.mark.parametrize(("density", "seed"), [(0.0, 0), (1.5, 0), (0.5, -1)])
def test_wrong_settings_are_refused(density: float, seed: int) -> None:
    with pytest.raises(ValueError, match="density must be above 0|wiring_seed must"):
        PatternGenerator(density=density, wiring_seed=seed)
