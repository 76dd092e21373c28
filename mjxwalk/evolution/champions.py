"""Who is the champion of a run: chosen on some new terrains, and reported on others.

A walker that was the fittest of its generation was so on terrains that suited it, and one chosen on
ten new terrains was lucky there too; only figures from terrains that played no part in any choice
say how well it walks.
"""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import PRNGKeyArray

from mjxwalk.evolution.generation import Elites, Evaluator, Study, fittest
from mjxwalk.evolution.measuring import cost_of_transport, over_terrains, speed
from mjxwalk.runs import Champion

NUM_CHOOSING = 10  # ours: terrains that candidates are compared on
NUM_REPORTING = 10  # ours: further terrains that the chosen one is reported on


class Choice(NamedTuple):
    """The champion's weights and its figures."""

    genotype: Any
    champion: Champion


def choose(study: Study, evaluator: Evaluator, elites: Elites, key: PRNGKeyArray) -> Choice:
    """Returns the elite that gets farthest on new terrains, with its figures on ten others."""
    terrains = study.sample_terrains(key, NUM_CHOOSING + NUM_REPORTING, study.generations)
    # One call for both sets of terrains, empty places and all: what is compiled for it then serves
    # every run.
    outcome = evaluator.evaluate(elites.genotypes, terrains)
    distance = over_terrains(outcome.distance[:, :NUM_CHOOSING])
    best = fittest(np.where(elites.generation > 0, distance, np.nan))
    trials = jax.tree.map(lambda leaf: leaf[best, NUM_CHOOSING:], outcome)
    return Choice(
        genotype=jax.tree.map(lambda leaf: leaf[best], elites.genotypes),
        champion=Champion(
            generation=int(elites.generation[best]),
            distance_m=float(np.mean(trials.distance, dtype=np.float64)),
            fall_rate=float(np.mean(trials.fell)),
            speed_m_s=speed(trials.distance, trials.duration),
            cost_of_transport=cost_of_transport(trials.work, trials.distance, study.weight),
            terrains=NUM_REPORTING,
        ),
    )
