"""What populations have sensed: added up over generations, carried by genotypes, resumed."""

from typing import Any

import jax
import numpy as np
import pytest
from cart import Cart

from mjxwalk import evaluation
from mjxwalk.controllers import LinearFeedback
from mjxwalk.evolution import Evolution, RunState
from mjxwalk.experiments.experiment import Experiment, StrategyChoice
from mjxwalk.runs.trees import flatten, unflatten

CART = Cart()
EXPERIMENT = Experiment(
    name="cart",
    env=CART,
    controller=LinearFeedback(normalise=True),
    strategy=StrategyChoice(name="ars", options={"sigma": 0.3}),
    population_size=6,
    generations=3,
    terrains_per_evaluation=2,
)


def evolved(num: int, engine: str = "mjx", state: RunState | None = None) -> list[RunState]:
    evolution = Evolution(EXPERIMENT, evaluation.make_evaluator(EXPERIMENT, engine))
    states = (
        [evolution.start(3)] if state is None else [unflatten(evolution.start(3), flatten(state))]
    )
    for _ in range(num):
        states.append(evolution.advance(states[-1])[0])
    return states


def seen_by(population: Any, generation: int) -> np.ndarray:
    """Returns all that a population saw, by a loop over its walkers."""
    key = jax.random.fold_in(jax.random.key(3), generation)
    trials = EXPERIMENT.sample_trials(jax.random.split(key, 5)[1], 2)
    seen: list[Any] = []
    policy = EXPERIMENT.controller
    for place in range(EXPERIMENT.population_size):
        genotype = jax.tree.map(lambda leaf, at=place: leaf[at], population)
        for row in range(2):
            given = trials.given(row)
            state, memory = CART.reset(given), policy.init(genotype)
            while not bool(state.trial.done):
                seen.append(CART.observe(state))
                memory, action = policy.act(genotype, memory, seen[-1])
                state = CART.step(state, action, given)
    return np.asarray(seen, np.float64)


def test_mean_and_deviation_are_those_of_all_that_was_seen_in_all_generations() -> None:
    states = evolved(3)
    seen = [seen_by(state.population, int(state.generation)) for state in states[1:]]
    for generation in (1, 3):
        sensed: Any = states[generation].sensed
        every = np.concatenate(seen[:generation])
        assert sensed.num == len(every)
        np.testing.assert_allclose(sensed.mean, every.mean(0), rtol=1e-5, atol=1e-6)
        np.testing.assert_allclose(sensed.statistics.deviation, every.std(0), rtol=1e-4, atol=1e-6)


def test_genotypes_carry_what_was_sensed_before_their_generation() -> None:
    states = evolved(3)
    before: Any = states[2].sensed
    for part, all_of_it in zip(states[3].population.senses, before.statistics, strict=True):
        assert (part == all_of_it).all()
    assert not states[1].population.senses.mean.any()
    np.testing.assert_array_equal(states[3].elite.senses.mean, before.statistics.mean)


@pytest.mark.parametrize("engine", ["mjx", "lanes"])
def test_a_run_that_was_stopped_goes_on_to_the_same_bits(engine: str) -> None:
    whole, first = evolved(3, engine), evolved(1, engine)
    rest = evolved(2, engine, first[-1])
    for one, other in zip(flatten(whole[-1]).values(), flatten(rest[-1]).values(), strict=True):
        assert one.tobytes() == other.tobytes()


def test_number_of_threads_changes_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MJXWALK_LANES_THREADS", "1")
    alone: Any = evolved(2, "lanes")[-1].sensed
    monkeypatch.setenv("MJXWALK_LANES_THREADS", "2")
    together: Any = evolved(2, "lanes")[-1].sensed
    for one, other in zip(alone, together, strict=True):
        assert one.tobytes() == other.tobytes()
