"""Under which conditions a winner is tried, beside those that it evolved under.

A gait that holds at one step of the physics only is an artefact of that step, and one that holds
from one start only has learnt it by heart.
"""

import dataclasses
from typing import Any, NamedTuple

from jaxtyping import PRNGKeyArray

from mjxwalk.envs import LeggedEnv, Trials
from mjxwalk.tournament.results import AS_EVOLVED, HALF_STEP, PAPERS_STEP, PERTURBED

# ours: these trials have five times the steps, and so a fifth of the terrains. They are held since
# some gaits hold at half of a millisecond and not there.
PAPERS_SHARE = 5


class Setting(NamedTuple):
    """One set of conditions.

    Attributes:
      name: as in the figures.
      experiment: whose rollout obeys them.
      trials: that the winner is given.
    """

    name: str
    experiment: Any
    trials: Trials


def settings(experiment: Any, trials: Trials, key: PRNGKeyArray) -> list[Setting]:
    """Returns the conditions that can be set for an experiment, those of its evolution first.

    Args:
      experiment: that the walkers evolved in.
      trials: to try them in.
      key: of the perturbed starts.
    """
    found = [Setting(AS_EVOLVED, experiment, trials)]
    env = experiment.env
    if not isinstance(env, LeggedEnv):
        return found

    def under(other: LeggedEnv) -> Any:
        return dataclasses.replace(experiment, env=other)

    half = dataclasses.replace(env, timestep=env.timestep / 2)
    found.append(Setting(HALF_STEP, under(half), trials))
    if env.EXPLICIT_TIMESTEP is not None:
        explicit = dataclasses.replace(env, timestep=env.EXPLICIT_TIMESTEP, integrator="explicit")
        few = trials.take(slice(-(-trials.num // PAPERS_SHARE)))
        found.append(Setting(PAPERS_STEP, under(explicit), few))
    if env.START_DEPARTURES:
        started, departing = env.perturbed(key, trials)
        found.append(Setting(PERTURBED, under(started), departing))
    return found
