"""Who is champion where fitness alone counts."""

import dataclasses
from typing import Any

import jax
import numpy as np
from cart import Cart

from mjxwalk import evaluation
from mjxwalk.controllers import LinearFeedback
from mjxwalk.envs import trial
from mjxwalk.evolution import Evolution, champions
from mjxwalk.experiments.experiment import Experiment, StrategyChoice
from mjxwalk.rollout import Outcome

EXPERIMENT = Experiment(
    name="cart",
    env=Cart(),
    controller=LinearFeedback(normalise=True),
    strategy=StrategyChoice(name="ars", options={"sigma": 0.3}),
    population_size=6,
    generations=2,
    terrains_per_evaluation=1,
)


class FarFromZeroIsWorse:
    """Evaluates genotypes by minus the distance of their weights from a point, without physics."""

    def __init__(self, best: Any) -> None:
        self._best = best
        self.noise: list[Any] = []

    def evaluate(self, population: Any, trials: Any, /) -> Outcome:
        """Returns outcomes [pop, trial]."""
        self.noise.append(trials.noise)
        pairs = zip(jax.tree.leaves(population.weights), jax.tree.leaves(self._best), strict=True)
        off = np.zeros(len(population.weights.bias))
        for leaf, best in pairs:
            off += np.abs(np.asarray(leaf) - np.asarray(best)).reshape(len(off), -1).sum(1)
        fitness = np.broadcast_to(-off[:, None], (len(off), trials.num))
        zero = np.zeros(fitness.shape, np.float32)
        # The better ones fall, and do not get as far.
        values = {"distance": -fitness, "fell": fitness > np.median(fitness)}
        named = dict.fromkeys(Outcome._fields[1:8], zero) | values
        return Outcome(fitness=fitness, **named)  # type: ignore[arg-type]


def test_mean_of_the_last_population_is_champion_if_none_is_fitter() -> None:
    evolution = Evolution(EXPERIMENT, evaluation.make_evaluator(EXPERIMENT, "mjx"))
    state = evolution.start(0)
    for _ in range(2):
        state, _ = evolution.advance(state)
    mean = jax.tree.map(lambda leaf: np.mean(leaf, axis=0), state.population.weights)
    evaluator = FarFromZeroIsWorse(mean)
    chosen = champions.choose(EXPERIMENT, evaluator, state, jax.random.key(0))
    for leaf, expected in zip(
        jax.tree.leaves(chosen.genotype.weights), jax.tree.leaves(mean), strict=True
    ):
        np.testing.assert_allclose(leaf, expected, atol=1e-6)
    assert chosen.champion.generation == 2


def test_fittest_elite_is_champion_though_it_falls() -> None:
    evolution = Evolution(EXPERIMENT, evaluation.make_evaluator(EXPERIMENT, "mjx"))
    state = evolution.start(0)
    for _ in range(2):
        state, _ = evolution.advance(state)
    first = jax.tree.map(lambda leaf: leaf[-2], state.elites.genotypes)
    evaluator = FarFromZeroIsWorse(first.weights)
    chosen = champions.choose(EXPERIMENT, evaluator, state, jax.random.key(0))
    assert chosen.champion.generation == 1
    np.testing.assert_array_equal(chosen.genotype.weights.bias, first.weights.bias)


@dataclasses.dataclass(frozen=True, kw_only=True)
class NoisyCart(Cart):
    """A cart that is not quite pushed as it means to be."""

    action_noise: float = 0.1

    def sample_trials(self, key: Any, num: int, roughness: float | None = None) -> Any:
        """Returns trials with noise."""
        trials = super().sample_trials(key, num, roughness)
        return trials._replace(noise=trial.noise_seeds(key, num, self.action_noise))


def test_champions_are_chosen_and_reported_without_noise_on_their_actions() -> None:
    experiment = dataclasses.replace(EXPERIMENT, env=NoisyCart())
    evolution = Evolution(experiment, evaluation.make_evaluator(experiment, "mjx"))
    state, _ = evolution.advance(evolution.start(0))
    weights = jax.tree.map(lambda leaf: leaf[0], state.population.weights)
    evaluator = FarFromZeroIsWorse(weights)
    champions.choose(experiment, evaluator, state, jax.random.key(0))
    assert evaluator.noise == [None] * 3
