"""The planar walker's rollout: both engines, absurd weights, and bits that never change."""

import functools
from typing import Any

import jax
import numpy as np
import pytest
from engines.lanes.cases import AXES, CONTROLLER, ENV, TRIALS, given, weights

from mjxwalk.engines import lanes
from mjxwalk.envs import State, Trial
from mjxwalk.rollout import Walk, advance, rollout, start


@functools.cache
def engine(threads: int | None = None) -> lanes.Mapped:
    return lanes.vmap(functools.partial(rollout, ENV, CONTROLLER), AXES, threads=threads)


def bits(tree: Any) -> list[Any]:
    return [np.asarray(leaf).view(np.uint8) for leaf in jax.tree.leaves(tree)]


def take(tree: Any, which: Any) -> Any:
    return jax.tree.map(lambda leaf: leaf[which], tree)


@pytest.mark.slow
def test_one_step_from_random_states_agrees_with_jax_to_rounding() -> None:
    """Accelerations reach 1e3 rad/s2 a step of 1 ms, and cancel: 2e-5 of the largest speed."""

    def step(genotype: Any, trial: Trial, qpos: Any, qvel: Any) -> State:
        walk = start(ENV, CONTROLLER, genotype, trial)
        state = walk.state._replace(qpos=walk.state.qpos + qpos, qvel=qvel)
        return advance(ENV, CONTROLLER, genotype, trial, Walk(state, walk.memory)).state

    rng = np.random.default_rng(2)
    population = weights(500, 0.3)
    qpos = (rng.normal(size=(500, 9)) * 0.05).astype(np.float32)
    qvel = rng.normal(size=(500, 9)).astype(np.float32)
    args = (population, given(500), qpos, qvel)
    got = lanes.vmap(step, (*AXES, 0, 0))(*args)
    want = jax.jit(jax.vmap(step, (*AXES, 0, 0)))(*args)
    np.testing.assert_allclose(got.qpos, want.qpos, atol=1e-5)
    np.testing.assert_allclose(got.qvel, want.qvel, atol=2e-5 * np.abs(want.qvel).max())
    assert (got.trial.fell == np.asarray(want.trial.fell)).mean() > 0.99


@pytest.mark.slow
def test_a_thousand_outcomes_are_distributed_as_those_of_jax() -> None:
    """Contact is chaotic: a walker may differ, but below any level there are as many of them.

    Within 2 %: the distance of Kolmogorov and Smirnov, which two independent samples of that size
    exceed 49 times in 50, so an engine that changed the outcomes would be seen.
    """
    args = (weights(1_000, 0.3), given(1_000))
    got = engine()(*args)
    want = jax.jit(jax.vmap(functools.partial(rollout, ENV, CONTROLLER), AXES))(*args)
    for name in ("distance", "duration", "torque_cost"):
        ours, theirs = np.sort(getattr(got, name)), np.sort(getattr(want, name))
        levels = np.concatenate([ours, theirs])
        shares = [np.searchsorted(found, levels, side="right") / 1_000 for found in (ours, theirs)]
        assert np.abs(shares[0] - shares[1]).max() < 0.02, name
    assert abs(got.fell.mean() - np.asarray(want.fell).mean()) < 0.01


def test_outcomes_do_not_depend_on_threads_batch_or_lane() -> None:
    population = weights(97, 0.3)
    whole = engine()(population, given(97))
    for first, second in zip(bits(whole), bits(engine(1)(population, given(97))), strict=True):
        np.testing.assert_array_equal(first, second)
    which = np.random.default_rng(3).permutation(97)[:31]
    some = engine()(take(population, which), TRIALS.given((which % 3).astype(np.int32)))
    for first, second in zip(bits(take(whole, which)), bits(some), strict=True):
        np.testing.assert_array_equal(first, second)


def test_ten_thousand_absurd_walkers_end_and_disturb_nobody() -> None:
    population = weights(10_000, 0.3)
    rng = np.random.default_rng(4)
    absurd = np.array([np.nan, np.inf, -np.inf, 1e30, -1e30, 3e38, 1e-40, 0.0], np.float32)
    strange = np.arange(10_000) % 5 != 0

    def spoil(leaf: Any) -> Any:
        spoilt = leaf * (10.0 ** rng.uniform(-3, 30, len(leaf)).astype(np.float32)).reshape(
            -1, *[1] * (leaf.ndim - 1)
        )
        spoilt = np.where(rng.random(leaf.shape) < 0.1, rng.choice(absurd, leaf.shape), spoilt)
        return np.where(strange.reshape(-1, *[1] * (leaf.ndim - 1)), spoilt, leaf).astype(
            np.float32
        )

    with np.errstate(over="ignore"):
        outcome = engine()(jax.tree.map(spoil, population), given(10_000))
    assert np.isfinite(outcome.duration).all()
    assert (outcome.steps <= round(ENV.max_time / ENV.timestep) + 1).all()
    sane = np.flatnonzero(~strange)
    alone = engine()(take(population, sane), TRIALS.given((sane % 3).astype(np.int32)))
    for first, second in zip(bits(take(outcome, sane)), bits(alone), strict=True):
        np.testing.assert_array_equal(first, second)
