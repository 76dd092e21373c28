"""Pruning and rewiring of any policy: what `--set pruning.X` and `--set rewiring.X` make."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import experiments
from mjxwalk.experiments.experiment import StrategyChoice
from mjxwalk.experiments.pruning import Pruning
from mjxwalk.experiments.rewiring import Rewiring
from mjxwalk.runs.trees import flatten
from mjxwalk.settings import override

NAMES = ["walk", "walk+mlp", "walk+recurrent", "walk+ctrnn", "walk+harmonics"]


def small(name: str, strategy: str = "snes", **changes: Any) -> Any:
    options = {"sigma": 0.1, "initial_sigma": 0.1} if strategy.endswith("-ga") else {"sigma": 0.1}
    choice = StrategyChoice(name=strategy, options=options)
    return dataclasses.replace(experiments.get(name), strategy=choice, population_size=8, **changes)


def evolved(experiment: Any, num: int) -> tuple[Any, Any]:
    """Returns the last of so many populations, told an order for fitness, and the last metrics."""
    strategy = experiment.make_strategy()
    ask, tell = jax.jit(strategy.ask), jax.jit(strategy.tell)
    state = jax.jit(strategy.init)(jax.random.key(0), experiment.template())
    population, metrics = None, None
    for key in jax.random.split(jax.random.key(1), num):
        key_ask, key_tell = jax.random.split(key)
        population, state = ask(key_ask, state)
        state, metrics = tell(key_tell, population, 10.0 + jnp.arange(8.0), state)
    return population, metrics


@pytest.mark.parametrize("name", NAMES)
def test_every_policy_loses_links_and_nothing_else(name: str) -> None:
    experiment = override(small(name), "rewiring.every", "1")
    experiment = override(experiment, "rewiring.density", "0.3")
    assert experiment.rewiring == Rewiring(every=1, density=0.3)
    population, _ = evolved(experiment, 7)
    links = flatten(experiment.controller.prunable())
    for leaf, values in flatten(population).items():
        of_links = links[leaf] >= 0
        assert np.all(values[:, ~of_links & flatten(experiment.controller.mask())[leaf]] != 0)
        if of_links.any():
            assert np.mean(values[:, of_links] != 0) < 0.75, leaf


@pytest.mark.parametrize("strategy", ["snes", "self-adaptive-ga"])
def test_the_studys_pruning_takes_links_of_a_perceptron(strategy: str) -> None:
    experiment = override(small("walk+mlp", strategy), "pruning.every", "1")
    for path, value in (("reference", "2"), ("window", "1")):
        # What is compared with comes last, since it must be no shorter than the window.
        experiment = override(experiment, "pruning.window", "1")
        experiment = override(experiment, f"pruning.{path}", value)
    assert experiment.pruning == Pruning(every=1, window=1, reference=2)
    _, metrics = evolved(experiment, 5)
    assert int(metrics.num_pruned) > 0


def test_pruning_goes_on_from_the_population_of_a_strategy_without_masks() -> None:
    before = small("walk+mlp")
    strategy = before.make_strategy()
    state = strategy.init(jax.random.key(3), before.template())
    arrays = flatten(state.inner)  # as inheritance gives them: the innermost state's
    for pruning, rewiring in ((Pruning(), None), (None, Rewiring()), (None, None)):
        after = small("walk+mlp", start="population", pruning=pruning, rewiring=rewiring)
        pruner = after.make_strategy()
        fresh = pruner.init(jax.random.key(4), after.template())
        taken = after.take_over(pruner, fresh, arrays, np.ones(3, np.float32))
        assert jax.tree.structure(taken) == jax.tree.structure(fresh)
        while hasattr(taken, "inner"):
            taken = taken.inner
        np.testing.assert_array_equal(taken.mean, state.inner.mean)


def test_a_genetic_algorithm_has_a_mutation_rate_for_each_layer() -> None:
    experiment = small("walk+mlp", "self-adaptive-ga")
    strategy = experiment.make_strategy()
    state = strategy.init(jax.random.key(0), experiment.template())
    assert state.learning_rates.shape == (8, len(experiment.controller.hidden) + 1)


def test_pruning_and_rewiring_exclude_each_other() -> None:
    with pytest.raises(ValueError, match="pruning and rewiring exclude each other"):
        small("walk", pruning=Pruning(), rewiring=Rewiring())
    with pytest.raises(ValueError, match="restart_after must be null"):
        small("walk", rewiring=Rewiring(), restart_after=3)
    with pytest.raises(ValueError, match="density must be above 0 and at most 1, got 2.0"):
        Rewiring(density=2.0)
