"""Tests of the second opinion on what walkers are worth and on what numbers ask of motors."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from verify.stepped import BODIES, TOY

from mjxwalk import robots
from mjxwalk.controllers.linear_feedback import LinearFeedback
from mjxwalk.envs import FitnessTerms, MjcfEnv
from mjxwalk.envs.fitness_terms import COSTS
from mjxwalk.rollout import advance, start
from mjxwalk.verify import laws, trials

WANTED = {"speed": 0.2, "clear_height": 0.01}
NAMES = [field.name for field in dataclasses.fields(FitnessTerms) if field.name not in WANTED]
SIGNED: Any = {name: -1.0 if name in COSTS else 1.0 for name in NAMES}
LENIENT: Any = {"max_time": 0.2, "max_pitch": 9.0, "max_roll": 9.0, "min_height": 0.1}
BODY = {"toy": TOY, "walker2d": robots.text("walker2d")}


@pytest.mark.parametrize("name", BODIES)
def test_numbers_ask_of_motors_what_the_environment_says(name: str) -> None:
    env = BODIES[name]
    numbers = np.random.default_rng(0).uniform(-1.5, 1.5, (20, len(env.anatomy.motors)))
    found = laws.of_numbers(env.anatomy, numbers)
    expected: Any = jax.vmap(env.scaled_action)(jnp.float32(numbers))
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-6)  # float32 there


@pytest.mark.slow
@pytest.mark.parametrize("name", BODY)
def test_a_walker_is_worth_the_same_by_every_term(name: str) -> None:
    env = MjcfEnv.of(BODY[name], terms=FitnessTerms(**WANTED, **SIGNED), **LENIENT)
    controller = LinearFeedback(rates=True, period=0.007).on(env)
    random = np.random.default_rng(1)
    genotype = jax.tree.map(
        lambda leaf: np.float32(random.normal(scale=0.3, size=leaf.shape)), controller.template()
    )
    trial = env.level_trials()

    state = last_state(env, controller, genotype)
    aside = () if env.anatomy.root.sideways is not None else ("drift", "heading")
    for term in NAMES:
        weights: Any = dict.fromkeys(NAMES, 0.0) | {term: SIGNED[term]}
        alone = dataclasses.replace(env, terms=FitnessTerms(**WANTED, **weights))
        found = trials.run(alone, controller, genotype, trial)
        assert int(found.steps[0]) == int(state.trial.num_steps) > 50
        expected = float(alone.fitness(state))
        # What a term counts, float32 adds up over the steps.
        np.testing.assert_allclose(found.fitness[0], expected, rtol=1e-3, err_msg=term)
        assert (expected == 0.0) == (term in aside)


@pytest.mark.slow
def test_a_trial_ends_as_a_forbidden_body_touches_the_ground() -> None:
    rules: Any = {"max_time": 3.0, "max_flight_time": 3.0, "max_pitch": 9.0, "max_lag": 9.0}
    env = MjcfEnv.of(TOY, acting="torque", forbidden=("trunk",), min_height=0.01, **rules)
    controller = LinearFeedback().on(env)
    limp = jax.tree.map(jnp.zeros_like, controller.template())
    state = last_state(env, controller, limp)
    found = trials.run(env, controller, limp, env.level_trials())
    # It falls at some 2 m/s, 4 mm a step.
    assert abs(int(found.steps[0]) - int(state.trial.num_steps)) <= 1
    assert found.fell[0] and bool(state.own.tally.forbidden) and 0.1 < found.duration[0] < 2.9


def last_state(env: Any, controller: Any, genotype: Any) -> Any:
    given = env.level_trials().given(np.int32(0))

    @jax.jit
    def walk() -> Any:
        return jax.lax.while_loop(
            lambda now: ~now.state.trial.done,
            lambda now: advance(env, controller, genotype, given, now),
            start(env, controller, genotype, given),
        ).state

    return walk()
