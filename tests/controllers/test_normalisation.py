"""Normalised senses, and policies over tasks without a body."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cart import Cart

from mjxwalk.controllers import (
    Harmonics,
    LinearFeedback,
    Mlp,
    PatternGenerator,
    Policy,
    RecurrentNetwork,
)
from mjxwalk.controllers.normalisation import Normalised, Statistics
from mjxwalk.envs import Trials
from mjxwalk.rollout import rollout

CART = Cart()
START = np.array([0.25], np.float32)
GIVEN = Trials(np.zeros((1, 1), np.float32), START[None]).given(0)
EVERY: list[Policy] = [
    LinearFeedback(),
    Mlp(hidden=(4,)),
    RecurrentNetwork(units=3),
    PatternGenerator(neurons=2),
    Harmonics(),
]


def drawn(policy: Policy, seed: int = 0) -> Normalised:
    """Returns a genotype of a normalising policy with weights everywhere."""
    draws = np.random.default_rng(seed)
    genotype = policy.template()
    weights = jax.tree.map(
        lambda leaf: jnp.asarray(0.5 * draws.normal(size=leaf.shape), jnp.float32),
        genotype.weights,
    )
    return genotype._replace(weights=weights)


def test_linear_policy_of_an_array_is_the_weighted_sum_of_what_it_sees() -> None:
    policy = LinearFeedback().on(CART)
    genotype = policy.template()._replace(
        weights=jnp.array([[0.5, -0.25, 0.0]]), bias=jnp.array([0.125])
    )
    seen = jnp.array([1.0, 2.0, 3.0])
    _, action = policy.act(genotype, policy.init(genotype), seen)
    assert float(action[0]) == 0.5 - 0.5 + 0.125


def test_normalised_sense_is_its_distance_from_the_mean_in_deviations_and_cut() -> None:
    policy = LinearFeedback(normalise=True, limit=2.0).on(CART)
    senses = Statistics(jnp.asarray(9.0), jnp.array([1.0, 0.0, 3.0]), jnp.array([2.0, 0.1, 0.0]))
    weights = policy.weights()._replace(weights=jnp.array([[0.25, 0.125, 1.0]]))
    # (2 - 1) / 2 = 0.5; 5 / 0.1 is cut to 2; what never varied is seen as it is, less its mean.
    _, action = policy.act(
        Normalised(weights, senses),
        policy.init(Normalised(weights, senses)),
        jnp.array([2, 5, 3.0]),
    )
    np.testing.assert_allclose(action, [0.25 * 0.5 + 0.125 * 2.0], rtol=1e-6)


@pytest.mark.parametrize("policy", EVERY, ids=lambda policy: type(policy).__name__)
def test_every_policy_drives_a_task_without_a_body(policy: Policy) -> None:
    policy = dataclasses.replace(policy, normalise=True).on(CART)
    outcome = rollout(CART, policy, drawn(policy), GIVEN)
    assert int(outcome.steps) == CART.steps
    assert float(outcome.fitness) != float(START[0])  # it was pushed


def test_sums_of_a_trial_are_those_of_what_was_seen_in_it() -> None:
    policy = LinearFeedback(normalise=True).on(CART)
    genotype = drawn(policy)
    mean = jnp.array([0.5, -0.5, 3.0])
    genotype = genotype._replace(senses=genotype.senses._replace(mean=mean))
    seen: list[np.ndarray] = []
    state, memory = CART.reset(GIVEN), policy.init(genotype)
    while not bool(state.trial.done):
        seen.append(np.asarray(CART.observe(state), np.float64))
        memory, action = policy.act(genotype, memory, CART.observe(state))
        state = CART.step(state, action, GIVEN)
    sums = rollout(CART, policy, genotype, GIVEN).sensed
    away = np.stack(seen) - np.asarray(mean, np.float64)
    assert float(sums.num) == len(seen) == CART.steps
    np.testing.assert_allclose(sums.total, away.sum(0), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(sums.squares, (away**2).sum(0), rtol=1e-5, atol=1e-6)


def test_strategies_leave_what_is_known_of_the_senses_alone() -> None:
    policy = LinearFeedback(normalise=True).on(CART)
    assert not any(np.any(leaf) for leaf in policy.mask().senses)
    assert all(np.all(np.asarray(leaf) == -1) for leaf in policy.prunable().senses)


def test_policy_without_named_senses_is_refused_in_a_sentence() -> None:
    class Nameless:
        timestep = 0.1

    with pytest.raises(ValueError, match="Nameless must have observation_names"):
        LinearFeedback().on(Nameless())
