"""Tests of the evaluator that is compiled while a run goes on."""

import threading
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import toy

from mjxwalk.envs import Trials
from mjxwalk.evolution.background_compile import BackgroundCompile
from mjxwalk.experiments import run_config
from mjxwalk.experiments.goal import Goal
from mjxwalk.experiments.run_config import Config
from mjxwalk.rollout import Outcome

TOY = toy.Toy()
POPULATION = jax.tree.map(lambda leaf: np.asarray(leaf)[None], TOY.template())
TRIALS, OTHERS = Trials(jnp.zeros((3, 1))), Trials(jnp.full((3, 1), 0.1))


class Slow:
    """Waits for a signal before its first evaluation; takes down the shapes."""

    def __init__(self) -> None:
        self.signal = threading.Event()
        self.shapes: list[int] = []

    def evaluate(self, population: Any, trials: Any, /) -> Outcome:
        assert self.signal.wait(60)
        self.shapes.append(trials.num)
        return toy.ToyEvaluator(TOY, "auto").evaluate(population, trials)


def test_it_compiles_beside_the_run_and_then_gives_the_same() -> None:
    slow = Slow()
    with BackgroundCompile(lambda: slow, POPULATION, TRIALS) as compiled:
        compiled.start()
        compiled.start()
        compiled.check()  # neither done nor failed
        assert slow.shapes == []
        slow.signal.set()
        outcome = compiled.evaluate(POPULATION, OTHERS)
    assert slow.shapes == [3, 3]
    expected = toy.ToyEvaluator(TOY, "auto").evaluate(POPULATION, OTHERS)
    jax.tree.map(np.testing.assert_array_equal, outcome, expected)


def test_what_fails_in_the_thread_fails_in_the_run() -> None:
    def fail() -> Slow:
        raise OSError("no compiler here")

    with BackgroundCompile(fail, POPULATION, TRIALS) as compiled:
        with pytest.raises(OSError, match="no compiler here"):
            compiled.evaluate(POPULATION, TRIALS)
        with pytest.raises(OSError, match="no compiler here"):
            compiled.check()


def test_a_thread_that_never_started_is_not_waited_for() -> None:
    with BackgroundCompile(Slow, POPULATION, TRIALS) as compiled:
        compiled.check()


def test_a_run_stops_when_its_finer_evaluator_cannot_be_made(tmp_path: Path) -> None:
    def fail() -> Slow:
        raise OSError("no compiler here")

    study = toy.Toy(generations=1000, goal=Goal(trials=5, duration=1e9, fine_trials=5))
    config = Config(experiment=study)
    run_config.create(tmp_path / "a", config)
    with BackgroundCompile(fail, POPULATION, TRIALS) as finer:
        with pytest.raises(OSError, match="no compiler here"):
            toy.evolve(tmp_path / "a", config, finer=finer)
    with pytest.raises(ValueError, match="fine_trials is 5 and nobody runs them"):
        toy.evolve(tmp_path / "a", config)
