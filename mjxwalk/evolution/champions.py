"""Who is the champion of a run: chosen on some new terrains, and reported on others.

A walker that was the fittest of its generation was so on terrains that suited it, and one chosen on
ten new terrains was lucky there too; only figures from terrains that played no part in any choice
say how well it walks.
"""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import PRNGKeyArray

from mjxwalk.evolution.generation import Elites, Evaluator, Study
from mjxwalk.evolution.measuring import cost_of_transport, over_terrains, speed
from mjxwalk.runs import Champion

NUM_SCREENING = 10  # ours: terrains that all elites are compared on
NUM_FINALISTS = 5  # ours: of these are those that get farthest
NUM_CHOOSING = 90  # ours: further terrains that the finalists are compared on
NUM_REPORTING = 10  # ours: yet other terrains that the champion is reported on


class Choice(NamedTuple):
    """The champion's weights and its figures."""

    genotype: Any
    champion: Champion


def choose(study: Study, evaluator: Evaluator, elites: Elites, key: PRNGKeyArray) -> Choice:
    """Returns the elite that falls least on new terrains, with its figures on ten others.

    Of those that get farthest on a few terrains, that is; among equals the farthest counts.
    """
    num_terrains = NUM_SCREENING + NUM_CHOOSING + NUM_REPORTING
    terrains = study.sample_terrains(key, num_terrains, study.generations)
    screening = jax.tree.map(lambda leaf: leaf[:NUM_SCREENING], terrains)
    final = jax.tree.map(lambda leaf: leaf[NUM_SCREENING:], terrains)
    # Empty places are evaluated too: what is compiled for all then serves every run.
    distance = over_terrains(evaluator.evaluate(elites.genotypes, screening).distance)
    distance = np.where((elites.generation > 0) & np.isfinite(distance), distance, -np.inf)
    finalists = np.argsort(-distance, kind="stable")[:NUM_FINALISTS]
    genotypes = jax.tree.map(lambda leaf: np.asarray(leaf)[finalists], elites.genotypes)
    outcome = evaluator.evaluate(genotypes, final)
    chosen_by = jax.tree.map(lambda leaf: leaf[:, :NUM_CHOOSING], outcome)
    falls = np.sum(chosen_by.fell, axis=1)
    falls = np.where(np.isfinite(distance[finalists]), falls, NUM_CHOOSING + 1)
    best = int(np.lexsort((-over_terrains(chosen_by.distance), falls))[0])
    trials = jax.tree.map(lambda leaf: leaf[best, NUM_CHOOSING:], outcome)
    return Choice(
        genotype=jax.tree.map(lambda leaf: leaf[best], genotypes),
        champion=Champion(
            generation=int(elites.generation[finalists[best]]),
            distance_m=float(np.mean(trials.distance, dtype=np.float64)),
            fall_rate=float(np.mean(trials.fell)),
            speed_m_s=speed(trials.distance, trials.duration),
            cost_of_transport=cost_of_transport(trials.work, trials.distance, study.weight),
            terrains=NUM_REPORTING,
        ),
    )
