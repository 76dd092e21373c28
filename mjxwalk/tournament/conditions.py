"""Under which conditions a winner is tried, beside those that it evolved under.

A gait that holds at one step of the physics only is an artefact of that step, and one that holds
from one start only has learnt it by heart.
"""

import dataclasses
from typing import Any, NamedTuple

from jaxtyping import Array, PRNGKeyArray, Shaped

from mjxwalk.envs import Flame, Planar7, Reil
from mjxwalk.rollout import Environment
from mjxwalk.tournament.perturbed import perturbed, with_draws
from mjxwalk.tournament.results import AS_EVOLVED, HALF_STEP, PAPERS_STEP, PERTURBED

PAPERS_TIMESTEP = 0.0002  # s; Solomon et al. (2013), section 2.3, with explicit Euler steps

# ours: these trials have five times the steps, and so a fifth of the terrains. They are held since
# some gaits hold at half of a millisecond and not there.
PAPERS_SHARE = 5


class Setting(NamedTuple):
    """One set of conditions.

    Attributes:
      name: as in the figures.
      experiment: whose rollout obeys them.
      terrains: as the rollout takes them.
    """

    name: str
    experiment: Any
    terrains: Shaped[Array, "terrain ..."]


def settings(
    experiment: Any, terrains: Shaped[Array, "terrain ..."], key: PRNGKeyArray
) -> list[Setting]:
    """Returns the conditions that can be set for an experiment, those of its evolution first.

    Args:
      experiment: that the walkers evolved in.
      terrains: to try them on.
      key: of the perturbed starts.
    """
    found = [Setting(AS_EVOLVED, experiment, terrains)]
    env = experiment.env
    if isinstance(env, Environment):
        half = dataclasses.replace(experiment, env=_replaced(env, timestep=env.timestep / 2))
        found.append(Setting(HALF_STEP, half, terrains))
    if isinstance(env, Planar7):
        explicit = _replaced(env, timestep=PAPERS_TIMESTEP, integrator="explicit")
        few = terrains[: -(-terrains.shape[0] // PAPERS_SHARE)]
        found.append(Setting(PAPERS_STEP, dataclasses.replace(experiment, env=explicit), few))
    if isinstance(env, Planar7 | Flame | Reil):
        started = dataclasses.replace(experiment, env=perturbed(env))
        found.append(Setting(PERTURBED, started, with_draws(key, terrains)))
    return found


def _replaced(env: Any, **changes: Any) -> Any:
    return dataclasses.replace(env, **changes)
