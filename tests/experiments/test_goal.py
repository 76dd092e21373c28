"""Tests of the goal that ends a run."""

import dataclasses
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import toy
from toy import Toy, ToyEvaluator

from mjxwalk.envs import Trials
from mjxwalk.evolution import Evolution
from mjxwalk.experiments.experiment import StrategyChoice
from mjxwalk.experiments.goal import Goal
from mjxwalk.experiments.run_config import Config
from mjxwalk.rollout import Outcome
from mjxwalk.runs import folder
from mjxwalk.runs.checkpoints import restore_newest


class Scripted:
    """Walkers that are numbers: walker w falls on the terrains in `falls[w]`, and gets w m far."""

    def __init__(self, falls: list[set[int]], duration: float = 5.0) -> None:
        self.falls, self.duration = falls, duration
        self.asked: list[tuple[list[int], int]] = []

    def evaluate(self, population: Any, trials: Trials, /) -> Outcome:
        """Returns the script's outcomes."""
        walkers = [int(walker) for walker in population]
        self.asked.append((walkers, trials.num))
        return outcome(
            walkers,
            [[t in self.falls[w] for t in range(trials.num)] for w in walkers],
            self.duration,
        )


def outcome(distances: list[int], falls: Any, duration: float) -> Outcome:
    """Returns outcomes [pop, terrain]; fitness is distance."""
    fell = np.array(falls, bool)
    values = {name: np.zeros(fell.shape) for name in Outcome._fields}
    values["fitness"] = values["distance"] = np.repeat(np.array([distances]).T, fell.shape[1], 1)
    values["fell"] = fell
    values["duration"] = np.full(fell.shape, duration)
    return Outcome(**values)  # pyright: ignore[reportArgumentType] # numpy, as evaluators return


def found(
    goal: Goal, evaluator: Scripted, fell_before: list[bool], finer: Scripted | None = None
) -> int | None:
    """Looks among walkers 0, 1 ..., of which some fell in their generation."""
    population = np.arange(len(fell_before))
    before = outcome(population.tolist(), [[fell] for fell in fell_before], evaluator.duration)
    keys = (jax.random.key(0), jax.random.key(1))
    return goal.find(Toy(), evaluator, population, before, keys, finer)


def test_the_farthest_that_never_falls_is_found() -> None:
    goal = Goal(trials=30, duration=5.0)
    upright = [False] * 4
    assert found(goal, Scripted([set(), set(), set(), {7}]), upright) == 2
    # Only the farthest of those that stay up on the few terrains is tried on all.
    assert found(goal, Scripted([set(), set(), {25}, {7}]), upright) is None
    assert found(goal, Scripted([set(), set(), set(), set()]), [False, False, True, True]) == 1


def test_short_trials_miss_the_goal() -> None:
    walkers = [set[int]()] * 3
    assert found(Goal(trials=30, duration=5.0), Scripted(walkers), [False] * 3) == 2
    assert found(Goal(trials=30, duration=5.1), Scripted(walkers), [False] * 3) is None
    assert found(Goal(trials=30, distance=2.0), Scripted(walkers), [False] * 3) == 2
    assert found(Goal(trials=30, distance=2.1), Scripted(walkers), [False] * 3) is None


def test_a_share_of_trials_may_fail() -> None:
    falls = [{20, 70}]  # one of the first 64, and one of the 36 after them
    assert found(Goal(trials=100), Scripted(falls), [False]) is None
    assert found(Goal(trials=100, share=0.95), Scripted(falls), [False]) == 0
    assert found(Goal(trials=100, share=0.98), Scripted(falls), [False]) is None  # 35 of 36
    with pytest.raises(ValueError, match="share must be above 0"):
        Goal(trials=1, share=0.0)


def test_a_few_trials_spare_the_many() -> None:
    evaluator = Scripted([{0}, {1}])
    assert found(Goal(trials=30), evaluator, [False, False]) is None
    assert [num for _, num in evaluator.asked] == [8]
    evaluator = Scripted([{70}, {30}])
    assert found(Goal(trials=100), evaluator, [False, False]) is None
    assert [num for _, num in evaluator.asked] == [8, 64]


def test_nothing_is_tried_without_a_goal_or_when_all_have_fallen() -> None:
    evaluator = Scripted([set(), set()])
    assert found(Goal(), evaluator, [False, False]) is None
    assert found(Goal(trials=30), evaluator, [True, True]) is None
    assert evaluator.asked == []


def test_who_falls_at_a_finer_step_misses_the_goal() -> None:
    goal = Goal(trials=30, fine_trials=10, duration=5.0)
    steady = Scripted([set(), set()])
    assert found(goal, Scripted([set(), set()]), [False] * 2, steady) == 1
    # The one that passed all other trials is tried, and no other.
    assert steady.asked == [([1], 10)]
    assert found(goal, Scripted([set(), set()]), [False] * 2, Scripted([set(), {9}])) is None
    short = Scripted([set(), set()], duration=4.9)
    assert found(goal, Scripted([set(), set()]), [False] * 2, short) is None
    untried = Scripted([])
    assert found(goal, Scripted([{3}, {25}]), [False] * 2, untried) is None
    assert untried.asked == []
    with pytest.raises(ValueError, match="fine_trials is 10 and nobody runs them"):
        found(goal, Scripted([set()]), [False])


def test_the_goal_is_tried_on_the_ground_of_the_environment() -> None:
    asked: list[float | None] = []

    class Rougher(Toy):
        def sample_trials(self, key: Any, num: int, roughness: float | None = None) -> Any:
            asked.append(roughness)
            return super().sample_trials(key, num, roughness)

    before = outcome([3], [[False]], 5.0)
    keys = (jax.random.key(0), jax.random.key(1))
    walkers = np.arange(1)
    trying = Scripted([set()])
    goal = Goal(trials=5, fine_trials=5)
    assert goal.find(Rougher(), trying, walkers, before, keys, trying) == 0
    assert asked == [None, None]


@pytest.mark.parametrize(
    "settings",
    [
        {"trials": -1},
        {"fine_trials": -1},
        {"fine_factor": 1},
        {"duration": -1.0},
        {"distance": np.nan},
    ],
)
def test_wrong_settings_are_refused(settings: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(settings))):
        Goal(**settings)


def test_a_run_ends_at_its_goal_and_stays_ended_when_resumed(tmp_path: Path) -> None:
    # A toy "falls" at more than 5 from its optimum; generation 1 starts about 6 to 9 from it.
    start = StrategyChoice(name="self-adaptive-ga", options={"sigma": 0.05, "initial_sigma": 0.01})
    goal = Goal(trials=30, duration=1.0)
    study = dataclasses.replace(Toy(), generations=200, goal=goal, strategy=start)
    config = Config(experiment=study, seed=3)
    result = toy.evolve(tmp_path, config)
    assert 1 < result.generations < 200
    # The result is written last: without it, resuming finds the goal reached and ends at once.
    (tmp_path / "result.json").unlink()
    again = toy.evolve(tmp_path, config)
    assert again.generations == result.generations
    assert again.champion == result.champion
    generation, arrays, _ = restore_newest(tmp_path / folder.CHECKPOINTS)
    assert generation == result.generations and arrays["reached"]


def test_the_goal_does_not_change_what_evolves() -> None:
    open_ended = Toy()
    with_goal = dataclasses.replace(open_ended, goal=Goal(trials=30, duration=1e9))
    ends = []
    for study in (open_ended, with_goal):
        evolution = Evolution(study, ToyEvaluator(study, "mjx"))
        state = evolution.start(0)
        for _ in range(3):
            state, _ = evolution.advance(state)
        ends.append(state)
    jax.tree.map(np.testing.assert_array_equal, *ends)
    assert not jnp.any(ends[1].reached)
