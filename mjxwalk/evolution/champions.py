"""Who is the champion of a run: chosen on some new terrains, and reported on others.

A walker that was the fittest of its generation was so on terrains that suited it, and one chosen on
ten new terrains was lucky there too; only figures from terrains that played no part in any choice
say how well it walks.
"""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import PRNGKeyArray

from mjxwalk.evolution.elites import Elites
from mjxwalk.evolution.evolvable import Evolvable
from mjxwalk.evolution.generation import RunState
from mjxwalk.experiments.experiment import Experiment
from mjxwalk.experiments.goal import take
from mjxwalk.fitting import Fitting
from mjxwalk.outcomes import cost_of_transport, over_terrains, speed
from mjxwalk.rollout import Outcome, TrialRunner
from mjxwalk.runs import Champion

NUM_SCREENING = 10  # ours: terrains that all elites are compared on
NUM_FINALISTS = 5  # ours: of these are those that get farthest
NUM_CHOOSING = 100  # ours: further terrains that the finalists are compared on
NUM_REPORTING = 10  # ours: yet other terrains that the champion is reported on


class Choice(NamedTuple):
    """The champion's weights and its figures."""

    genotype: Any
    champion: Champion


def choose(
    experiment: Evolvable, evaluator: TrialRunner, state: RunState, key: PRNGKeyArray
) -> Choice:
    """Returns the walker that reached the goal, or else the best elite, with its figures."""
    if isinstance(experiment, Fitting):
        return _fitted(experiment, state.elites)
    key_choosing, key_reporting = jax.random.split(key)
    if state.reached:
        genotype, generation = state.elite, int(state.generation)
    else:
        elites = state.elites
        if _counts_fitness(experiment):
            # Strategies that follow a gradient never try the mean of what they draw, which is
            # what they have found.
            mean = jax.tree.map(_mean, state.population)
            elites = elites.push(mean, np.nan, int(state.generation))
        place = _best(experiment, evaluator, elites, key_choosing)
        genotype = jax.tree.map(lambda leaf: leaf[place], elites.genotypes)
        generation = int(elites.generation[place])
    given = _without_noise(experiment.sample_trials(key_reporting, NUM_REPORTING))
    alone = jax.tree.map(lambda leaf: np.asarray(leaf)[None], genotype)
    trials = evaluator.evaluate(alone, given)
    return Choice(
        genotype=genotype,
        champion=Champion(
            generation=generation,
            distance_m=float(np.mean(trials.distance, dtype=np.float64)),
            fall_rate=float(np.mean(trials.fell)),
            speed_m_s=speed(trials.distance, trials.duration),
            cost_of_transport=cost_of_transport(trials.work, trials.distance, experiment.weight),
            terrains=NUM_REPORTING,
            fitness=_finite_mean(trials.fitness),
        ),
    )


def _fitted(experiment: Fitting, elites: Elites) -> Choice:
    """Returns the fittest elite: without chance in an evaluation, that is all there is to know."""
    fitness = np.where(np.isfinite(elites.fitness), elites.fitness, -np.inf)
    place = int(np.argmax(fitness))
    genotype = jax.tree.map(lambda leaf: leaf[place], elites.genotypes)
    return Choice(
        genotype=genotype,
        champion=Champion(
            generation=int(elites.generation[place]),
            distance_m=0.0,
            fall_rate=0.0,
            speed_m_s=None,
            cost_of_transport=None,
            terrains=0,
            figures=experiment.judge(genotype),
        ),
    )


def _best(experiment: Evolvable, evaluator: TrialRunner, elites: Elites, key: PRNGKeyArray) -> int:
    """Returns the place of the elite that falls least on new terrains; then distance counts.

    Of those that get farthest on a few terrains, that is. Where fitness counts, it alone does.
    """
    by_fitness = _counts_fitness(experiment)

    def worth(outcome: Outcome) -> Any:
        return over_terrains(outcome.fitness if by_fitness else outcome.distance)

    given = _without_noise(experiment.sample_trials(key, NUM_SCREENING + NUM_CHOOSING))
    screening, choosing = (
        given.take(part) for part in (slice(NUM_SCREENING), slice(NUM_SCREENING, None))
    )
    # Empty places are evaluated too: what is compiled for all then serves every run.
    first = worth(evaluator.evaluate(elites.genotypes, screening))
    first = np.where((elites.generation > 0) & np.isfinite(first), first, -np.inf)
    finalists = np.argsort(-first, kind="stable")[:NUM_FINALISTS]
    outcome = evaluator.evaluate(take(elites.genotypes, finalists), choosing)
    falls = np.zeros(NUM_FINALISTS) if by_fitness else np.sum(outcome.fell, axis=1)
    falls = np.where(first[finalists] > -np.inf, falls, NUM_CHOOSING + 1)
    return int(finalists[np.lexsort((-worth(outcome), falls))[0]])


def _without_noise(trials: Any) -> Any:
    """Returns trials in which walkers act as they mean to, as they do where they are tested."""
    return trials if getattr(trials, "noise", None) is None else trials._replace(noise=None)


def _counts_fitness(experiment: Any) -> bool:
    """Returns whether fitness alone says who is best: in tasks that are not about a body's walk."""
    env = getattr(experiment, "env", None)
    return isinstance(experiment, Experiment) and not hasattr(env, "anatomy")


def _finite_mean(values: Any) -> float | None:
    mean = float(np.mean(values, dtype=np.float64))
    return mean if np.isfinite(mean) else None


def _mean(leaf: Any) -> Any:
    return np.mean(leaf, axis=0, dtype=np.float64).astype(leaf.dtype)
