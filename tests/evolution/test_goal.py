"""Tests of the goal that ends a run."""

import dataclasses
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from toy import Toy, ToyEvaluator

from mjxwalk.evolution import Evolution, Goal, evolve
from mjxwalk.experiments.experiment import StrategyChoice
from mjxwalk.rollout import Outcome
from mjxwalk.runs import Config, Metrics, folder
from mjxwalk.runs.checkpoints import restore_newest


class Silent:
    """Shows nothing."""

    def generation(self, line: Metrics, /) -> None:
        """Does nothing."""

    def say(self, text: str, /) -> None:
        """Does nothing."""


class Scripted:
    """Walkers whose trials on terrain i end by a fall if and only if `falls[i]`."""

    def __init__(self, falls: list[bool], duration: float) -> None:
        self.falls, self.duration = np.array(falls), duration
        self.asked: list[int] = []

    def evaluate(self, population: Any, heights: Any, /) -> Outcome:
        """Returns the script's outcomes."""
        num = len(heights)
        self.asked.append(num)
        values = {name: np.zeros((1, num)) for name in Outcome._fields}
        values["fell"] = self.falls[None, :num]
        values["duration"] = np.full((1, num), self.duration)
        return Outcome(**values)  # pyright: ignore[reportArgumentType] # numpy, as evaluators return


def reached(goal: Goal, evaluator: Scripted) -> bool:
    study = Toy()
    genotype = study.template()
    return goal.reached(study, evaluator, genotype, jax.random.key(0), 1)


def test_a_single_fall_or_a_short_trial_misses_the_goal() -> None:
    goal = Goal(trials=30, duration=5.0)
    assert reached(goal, Scripted([False] * 30, 5.0))
    assert not reached(goal, Scripted([False] * 29 + [True], 5.0))
    assert not reached(goal, Scripted([False] * 30, 4.9))


def test_a_fall_among_the_first_spares_the_other_trials() -> None:
    evaluator = Scripted([True] + [False] * 29, 5.0)
    assert not reached(Goal(trials=30), evaluator)
    assert evaluator.asked == [20]


def test_without_a_goal_nothing_is_tried() -> None:
    evaluator = Scripted([], 5.0)
    assert not reached(Goal(), evaluator)
    assert evaluator.asked == []


@pytest.mark.parametrize("settings", [{"trials": -1}, {"duration": -1.0}, {"duration": np.nan}])
def test_wrong_settings_are_refused(settings: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(settings))):
        Goal(**settings)


def test_a_run_ends_at_its_goal_and_stays_ended_when_resumed(tmp_path: Path) -> None:
    # A toy "falls" at more than 5 from its optimum; generation 1 starts about 6 to 9 from it.
    start = StrategyChoice(name="self-adaptive-ga", options={"sigma": 0.05, "initial_sigma": 0.01})
    goal = Goal(trials=30, duration=1.0)
    study = dataclasses.replace(Toy(), generations=200, goal=goal, strategy=start)
    config = Config(experiment=study, seed=3)
    result = evolve(tmp_path, config, ToyEvaluator(study, "mjx"), Silent())
    assert 1 < result.generations < 200
    # The result is written last: without it, resuming finds the goal reached and ends at once.
    (tmp_path / "result.json").unlink()
    again = evolve(tmp_path, config, ToyEvaluator(study, "mjx"), Silent())
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
