"""Holds a tournament: compares the entrants on some terrains, tries the winner on others."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float, PRNGKeyArray

from mjxwalk import budget, evaluation
from mjxwalk.analysis.intervals import wilson
from mjxwalk.engines.pinning import pinned
from mjxwalk.envs import Trials
from mjxwalk.evaluation import TABLE_ROWS
from mjxwalk.outcomes import cost_of_transport
from mjxwalk.rollout import Outcome
from mjxwalk.tournament import conditions, steps
from mjxwalk.tournament.conditions import Setting
from mjxwalk.tournament.entrants import Entrants
from mjxwalk.tournament.results import Condition, Tournament
from mjxwalk.tournament.steps import Steps

# Folded into the seed's key, it leads away from all keys of runs, which fold in generations.
TOURNAMENT = 0x746F7572


class Keys(NamedTuple):
    """What a tournament draws from; each is used once."""

    screening: PRNGKeyArray
    reporting: PRNGKeyArray
    starts: PRNGKeyArray


@pinned()
def compete(
    entrants: Entrants,
    *,
    engine: str,
    seed: int,
    screening: int,
    terrains: int,
    say: Callable[[str], None],
) -> Tournament:
    """Returns the winner and its figures; `mjxwalk.tournament.compete` tells the arguments.

    Raises:
      ValueError: there is no such engine, or a number is wrong.
    """
    _check(entrants, seed=seed, screening=screening, terrains=terrains)
    experiment, keys = entrants.experiment.as_tested(), draw_keys(seed)
    budget.check_grounds(experiment.env, terrains)
    evaluator = evaluation.make_evaluator(experiment, engine)
    place = 0
    if len(entrants) > 1:
        say(f"comparing {len(entrants)} walkers on {screening} new terrains")
        given = experiment.sample_trials(keys.screening, screening)
        screened = _evaluate(evaluator, entrants.genotypes, given)
        place = winner(np.asarray(screened.fitness))
    genotype = jax.tree.map(lambda leaf: np.asarray(leaf)[[place]], entrants.genotypes)
    given = experiment.sample_trials(keys.reporting, terrains)
    figures = [
        _try(setting, genotype, engine, say)
        for setting in conditions.settings(experiment, given, keys.starts)
    ]
    return Tournament(
        entrants=len(entrants),
        newest_generation=int(entrants.generations.max()),
        winner_generation=int(entrants.generations[place]),
        screening_terrains=screening if len(entrants) > 1 else 0,
        seed=seed,
        engine=evaluator.engine,
        roughness_m=roughness(experiment),
        conditions=tuple(figures),
    )


def draw_keys(seed: int) -> Keys:
    """Returns the keys of a tournament; no run has one of them, whatever its seed."""
    return Keys(*jax.random.split(jax.random.fold_in(jax.random.key(seed), TOURNAMENT), 3))


def winner(fitness: Float[np.ndarray, "entrant terrain"]) -> int:
    """Returns the place of the highest mean fitness; NaN is lower than any, of equals the newest.

    Solomon et al. (2013), section 2.7.3.
    """
    mean = np.mean(fitness, axis=1, dtype=np.float64)
    mean = np.where(np.isfinite(mean), mean, -np.inf)
    return len(mean) - 1 - int(np.argmax(mean[::-1]))


def summarise(name: str, outcome: Outcome, weight: float, walked: Steps) -> Condition:
    """Returns the figures of one walker's trials.

    Args:
      name: of the conditions.
      outcome: numpy arrays [1, terrain].
      weight: of the body, N.
      walked: its steps.
    """
    distance = np.asarray(outcome.distance[0], np.float64)
    fell = np.asarray(outcome.fell[0])
    interval = wilson(int(fell.sum()), len(fell))
    speeds = (distance / outcome.duration[0])[~fell]
    return Condition(
        name=name,
        trials=len(fell),
        distance_mean_m=float(distance.mean()),
        distance_sd_m=float(distance.std()),
        fall_rate=float(fell.mean()),
        fall_rate_low=interval.low,
        fall_rate_high=interval.high,
        cost_of_transport=cost_of_transport(outcome.work, outcome.distance, weight),
        speed_m_s=float(speeds.mean()) if speeds.size else None,
        step_length_m=walked.length_m,
        double_stance=walked.double_stance,
    )


def roughness(experiment: Any) -> float | None:
    """Returns the step of an experiment's random ground, m; None where there is no such setting."""
    return getattr(getattr(experiment.env, "terrain", None), "roughness", None)


def _try(setting: Setting, genotype: Any, engine: str, say: Callable[[str], None]) -> Condition:
    say(f"{setting.name}: {setting.trials.num} new terrains")
    evaluator = evaluation.make_evaluator(setting.experiment, engine)
    outcome = _evaluate(evaluator, genotype, setting.trials)
    walked = steps.measure(setting, genotype, np.asarray(outcome.fell[0]), evaluator.engine)
    return summarise(setting.name, outcome, setting.experiment.weight, walked)


def _evaluate(evaluator: Any, population: Any, trials: Trials) -> Outcome:
    """Returns outcomes [pop, trial], from parts of one size so that one compilation serves."""
    parts = [evaluator.evaluate(population, part) for part in _parts(trials)]
    return jax.tree.map(lambda *leaves: np.concatenate(leaves, axis=1), *parts)


def _parts(trials: Trials) -> Iterator[Trials]:
    num = -(-trials.num // TABLE_ROWS)
    for rows in np.array_split(np.arange(trials.num), num):
        yield trials.take(slice(rows[0], rows[-1] + 1))


def _check(entrants: Entrants, *, seed: int, screening: int, terrains: int) -> None:
    if not len(entrants):
        raise ValueError(f"{entrants.name} has no walkers")
    if not 0 <= seed < 2**32:
        raise ValueError(f"seed must be from 0 to {2**32 - 1}, got {seed}")
    for name, value in (("screening", screening), ("terrains", terrains)):
        if value < 1:
            raise ValueError(f"{name} must be at least 1, got {value}")
