"""Gymnasium's walking tasks, evolved by augmented random search.

Mania, Guy & Recht (2018), "Simple random search of static linear policies is competitive for
reinforcement learning", https://arxiv.org/abs/1803.07055, algorithm 2, V2 and V2-t: a linear policy
of normalised observations, from zero. As there, the bonus of being alive is removed while walkers
evolve; where they are tested it counts.
"""

from typing import Any, NamedTuple

from mjxwalk.controllers import LinearFeedback
from mjxwalk.envs.gymnasium import TASKS
from mjxwalk.experiments.experiment import Experiment, StrategyChoice

PREFIX = "gymnasium/"  # of the experiments' names


class _Search(NamedTuple):
    """Of the directions in a generation, how many count, step, and noise of weights."""

    directions: int
    used: int
    learning_rate: float
    sigma: float


# The paper's own, of tasks of an older version: Humanoid's as its repository has them,
# https://github.com/modestyachts/ARS; the others as RL Baselines3 Zoo has them of that paper,
# https://github.com/DLR-RM/rl-baselines3-zoo, hyperparams/ars.yml. Humanoid's actions are from -0.4
# to 0.4 there and from -1 to 1 here, so that step and noise are 2.5 times theirs.
SEARCHES = {
    "Walker2d-v5": _Search(40, 30, 0.03, 0.025),
    "Hopper-v5": _Search(8, 4, 0.01, 0.025),
    "HalfCheetah-v5": _Search(32, 4, 0.02, 0.03),
    "Ant-v5": _Search(60, 20, 0.015, 0.025),
    "Humanoid-v5": _Search(230, 230, 2.5 * 0.02, 2.5 * 0.0075),
}
GENERATIONS = 1_000  # ours


def of_task(name: str, body: str = "") -> Experiment:
    """Returns the experiment of a task.

    Args:
      name: of the task, as Gymnasium makes it.
      body: MJCF, in itself complete; "" for that of the installed Gymnasium.

    Raises:
      ValueError: it is no body of such a task, or Gymnasium is not installed.
    """
    task, search = TASKS[name](body=body), SEARCHES[name]
    tested: dict[str, Any] = {}
    if hasattr(task, "healthy_reward"):
        tested = {"healthy_reward": TASKS[name].healthy_reward}  # type: ignore[attr-defined]
        task = TASKS[name](body=task.body, healthy_reward=0.0)  # type: ignore[call-arg]
    return Experiment(
        name=f"{PREFIX}{name}",
        env=task,
        controller=LinearFeedback(normalise=True),
        strategy=StrategyChoice(
            name="ars",
            options={
                "sigma": search.sigma,
                "learning_rate": search.learning_rate,
                "used_fraction": search.used / search.directions,
            },
        ),
        population_size=2 * search.directions,
        generations=GENERATIONS,
        terrains_per_evaluation=1,
        test_settings=tested,
    )
