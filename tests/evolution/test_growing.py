"""Populations that grow: what is evaluated, what the strategy is told, and the same again."""

import dataclasses
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
import toy
from cart import Cart

from mjxwalk import evaluation, runs
from mjxwalk.cli import main
from mjxwalk.controllers import LinearFeedback
from mjxwalk.evolution import Evolution, RunState, growing
from mjxwalk.evolution.memory import check_settings
from mjxwalk.experiments.experiment import Experiment, StrategyChoice
from mjxwalk.experiments.goal import take
from mjxwalk.experiments.growth import Growth
from mjxwalk.experiments.pruning import Pruning
from mjxwalk.rollout import Outcome
from mjxwalk.runs import Metrics
from mjxwalk.runs.trees import flatten, unflatten

PGPE = StrategyChoice(name="pgpe", options={"sigma": 0.3})
PLAIN = toy.Toy(strategy=PGPE)


def growing_toy(part: int, interactions: int, **changes: Any) -> toy.Toy:
    return dataclasses.replace(
        PLAIN, growth=Growth(part=part, interactions=interactions), **changes
    )


class Counting(toy.ToyEvaluator):
    """The toy's evaluator, whose walkers do known steps, other ones in each generation."""

    def __init__(self, steps: list[int] | None = None) -> None:
        super().__init__(PLAIN, "auto")
        self._steps = list(steps or [])
        self.populations: list[Any] = []

    def evaluate(self, population: Any, trials: Any) -> Outcome:
        self.populations.append(population)
        outcome = super().evaluate(population, trials)
        if not self._steps:
            return outcome
        return outcome._replace(steps=np.full_like(outcome.steps, self._steps.pop(0)))


def advanced(
    experiment: Any, num: int = 1, evaluator: Any = None, state: RunState | None = None
) -> list[tuple[RunState, Metrics]]:
    evolution = Evolution(experiment, evaluator or Counting())
    after = evolution.start(3)
    if state is not None:
        after = unflatten(after, flatten(state))
    done: list[tuple[RunState, Metrics]] = []
    for _ in range(num):
        after, line = evolution.advance(after)
        done.append((after, line))
    return done


def same(one: Any, other: Any) -> bool:
    pairs = zip(flatten(one).items(), flatten(other).items(), strict=True)
    return all(a[0] == b[0] and a[1].tobytes() == b[1].tobytes() for a, b in pairs)


def test_parts_are_evaluated_until_their_steps_sum_to_the_interactions() -> None:
    # Two trials each, so that four walkers do eight times the steps of one.
    steps = [10, 20, 30] + [60] + [1, 1, 1, 1]
    evaluator = Counting(steps)
    lines = [line for _, line in advanced(growing_toy(4, 480), 3, evaluator)]
    assert [line.strategy["num_evaluated"] for line in lines] == [12, 4, 16]
    assert [line.physics_steps for line in lines] == [8 * 60, 8 * 60, 8 * 4]
    assert len(evaluator.populations) == len(steps)


def test_each_part_holds_both_of_a_pair() -> None:
    evaluator = Counting()
    advanced(growing_toy(4, 10**6), 1, evaluator)
    for part in evaluator.populations:
        noise = part.gain  # around the template, which is zeros
        np.testing.assert_array_equal(noise[:2], -noise[2:])
    assert len(np.unique([part.bias for part in evaluator.populations])) == 16


def test_a_population_that_grows_to_its_size_is_one_that_does_not_grow() -> None:
    for whole, grown in zip(advanced(PLAIN, 3), advanced(growing_toy(4, 10**6), 3), strict=True):
        assert same(whole[0], grown[0])


@pytest.mark.parametrize("name", ["pgpe", "openai-es"])
def test_the_strategy_goes_where_one_of_so_small_a_population_goes(name: str) -> None:
    choice = StrategyChoice(name=name, options=PGPE.options)
    experiment = growing_toy(6, 1, population_size=24, strategy=choice)
    before = Evolution(experiment, Counting()).start(3)
    state, line = advanced(experiment)[0]
    assert line.strategy["num_evaluated"] == 6
    small = dataclasses.replace(PLAIN, population_size=6, strategy=choice).make_strategy()
    places = np.array([0, 1, 2, 12, 13, 14])
    key = jax.random.split(jax.random.fold_in(jax.random.key(3), 1), 5)[2]
    population = take(state.population, places)
    told, _ = jax.jit(small.tell)(key, population, state.fitness[places], before.strategy)
    assert same(told, state.strategy)


def test_who_was_not_evaluated_has_no_fitness_and_is_no_elite() -> None:
    class Later(Counting):
        """An evaluator in which later parts would be the fittest."""

        def evaluate(self, population: Any, trials: Any) -> Outcome:
            outcome = super().evaluate(population, trials)
            return outcome._replace(fitness=outcome.fitness + 100 * len(self.populations))

    state, line = advanced(growing_toy(4, 10**3), 1, Later())[0]
    evaluated = np.isfinite(state.fitness)
    assert np.flatnonzero(evaluated).tolist() == [0, 1, 2, 3, 8, 9, 10, 11]
    for values in state.outcome:
        assert np.array_equal(np.isfinite(values), evaluated)
    best = int(np.nanargmax(state.fitness))
    assert best in (2, 3, 10, 11)  # of the second part, which is the last that was evaluated
    np.testing.assert_array_equal(state.elite.gain, state.population.gain[best])
    assert line.best_fitness == state.fitness[best]


class FallingCart(Cart):
    """A cart whose trial is longer the farther it is pushed."""

    def step(self, state: Any, action: Any, given: Any) -> Any:
        after = super().step(state, action, given)
        fell = after.qpos[0] < -0.5
        return after._replace(trial=after.trial._replace(done=after.trial.done | fell, fell=fell))


CART = Experiment(
    name="cart",
    env=FallingCart(),
    controller=LinearFeedback(normalise=True),
    strategy=PGPE,
    population_size=24,
    generations=3,
    terrains_per_evaluation=2,
    growth=Growth(part=4, interactions=220),
)


def on_lanes(num: int, state: RunState | None = None) -> list[tuple[RunState, Metrics]]:
    return advanced(CART, num, evaluation.make_evaluator(CART, "lanes"), state)


def test_a_run_that_was_stopped_goes_on_to_the_same_bits() -> None:
    whole = on_lanes(4)
    assert len({line.strategy["num_evaluated"] for _, line in whole}) > 1
    rest = on_lanes(2, whole[1][0])
    assert same(rest[-1][0], whole[-1][0])


def test_number_of_threads_changes_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MJXWALK_LANES_THREADS", "1")
    alone = on_lanes(2)
    monkeypatch.setenv("MJXWALK_LANES_THREADS", "2")
    assert same(on_lanes(2)[-1][0], alone[-1][0])


def test_what_is_compiled_beforehand_is_for_a_part() -> None:
    class Prepared(Counting):
        def prepare(self, population: Any, trials: Any) -> None:
            sizes.append(growing.size_of(population))

    sizes: list[int] = []
    Evolution(growing_toy(4, 100), Prepared()).start(0)
    assert sizes == [4]


def test_memory_has_to_hold_the_trials_of_a_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mjxwalk.budget.available", lambda: 16_000)
    check_settings(dataclasses.replace(CART, growth=Growth(part=4)))
    with pytest.raises(runs.RunError, match="1,000 walkers on 2 terrains"):
        check_settings(dataclasses.replace(CART, population_size=1000, growth=None))
    check_settings(dataclasses.replace(CART, population_size=1000))


def test_what_cannot_grow_is_refused_in_a_sentence() -> None:
    changed = dataclasses.replace
    with pytest.raises(ValueError, match="for the strategies pgpe and openai-es, .* got snes"):
        changed(CART, strategy=StrategyChoice(name="snes", options={"sigma": 1})).make_strategy()
    with pytest.raises(ValueError, match="population_size must be a multiple of growth.part, 4"):
        changed(CART, population_size=26).make_strategy()
    with pytest.raises(ValueError, match="growth excludes pruning, rewiring and restart_after"):
        changed(CART, pruning=Pruning())
    with pytest.raises(ValueError, match="part must be even, as noise is mirrored, got 3"):
        Growth(part=3)
    with pytest.raises(ValueError, match="interactions must be a number above 0, got 0"):
        Growth(interactions=0)


def test_the_command_tells_how_many_walkers_there_were(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)
    grown = ["--set", "growth.interactions=1000", "--set", "growth.part=4"]
    sigma = ["--strategy", "pgpe", "--set", "strategy.sigma=0.3"]
    assert main(["evolve", "toy", *sigma, *grown, "--out", "a"]) == 0
    said = capsys.readouterr().out
    assert "4 walkers and as many more, at most 16, until they have done 1,000 steps" in said
    assert "generation 6/6: walkers 8, fitness" in said
    assert runs.load("a").metrics["strategy.num_evaluated"].tolist() == [8] * 6
