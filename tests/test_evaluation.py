"""Populations evaluated from Python."""

import jax
import numpy as np
import pytest
from cart import Cart

from mjxwalk.controllers import LinearFeedback
from mjxwalk.evaluation import evaluate
from mjxwalk.rollout import rollout

CART = Cart()


@pytest.mark.parametrize("engine", ["mjx", "lanes"])
def test_outcomes_are_those_of_one_rollout_each(engine: str) -> None:
    policy = LinearFeedback().on(CART)
    keys = iter(jax.random.split(jax.random.key(0), 10))
    genotypes = jax.tree.map(
        lambda leaf: jax.random.normal(next(keys), (3, *leaf.shape)), policy.template()
    )
    trials = CART.sample_trials(jax.random.key(1), 2)
    # A controller that was not told of its environment is told here.
    outcome = evaluate(CART, LinearFeedback(), genotypes, trials, engine=engine)
    assert outcome.fitness.shape == (3, 2)
    for place, row in np.ndindex(3, 2):
        own = jax.tree.map(lambda leaf, at=place: leaf[at], genotypes)
        alone = rollout(CART, policy, own, trials.given(row))
        np.testing.assert_allclose(outcome.fitness[place, row], alone.fitness, rtol=1e-5)
        assert outcome.steps[place, row] == alone.steps
