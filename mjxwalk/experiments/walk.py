"""Any body of a file learns to walk: linear feedback of its senses to targets of its legs' joints.

Nothing here knows the body: lengths, times and torques are derived from its size and its weight.
"""

import dataclasses
from typing import Any, Literal

from mjxwalk import robots
from mjxwalk.controllers import LinearFeedback
from mjxwalk.envs import MjcfEnv
from mjxwalk.envs.derived import defaults
from mjxwalk.envs.mjcf import reader
from mjxwalk.experiments.experiment import Experiment, StrategyChoice
from mjxwalk.experiments.goal import Goal

NAME = "walk"
USUAL_BODY = "h1"
# ours: of the time that a fall from the height of the root takes, over the square root of two; a
# policy that acts less often falls sooner, one that acts more often gains nothing.
PERIOD = 0.06
# ours: with 0.1 and more, walkers settle on a lunge.
STRATEGY = StrategyChoice(name="snes", options={"sigma": 0.03})
DISTANCE = 20.0  # m; ours
TRIAL_TIME = 25.0  # s; ours: at the speed that is wanted, more than the distance takes


def period(time: float) -> float:
    """Returns how often a policy acts, s, by its body's time, s."""
    return float(f"{PERIOD * time:.1g}")


def of_body(text: str) -> Experiment:
    """Returns the experiment of a body.

    Args:
      text: MJCF, in itself complete.

    Raises:
      ValueError: the text is no body that can walk here.
    """
    # ours: walkers from one start alone fall from others; these take a fifth longer to evolve.
    env = MjcfEnv.of(text, perturbation=1.0)
    speed = env.terms.speed
    return Experiment(
        name=NAME,
        env=dataclasses.replace(env, max_time=round(max(TRIAL_TIME, 1.1 * DISTANCE / speed), 1)),
        controller=LinearFeedback(period=period(env.walking_time), moved=_moved(env)),
        strategy=STRATEGY,
        population_size=512,
        generations=600,
        terrains_per_evaluation=1,
        goal=Goal(trials=64, share=0.95, distance=DISTANCE, fine_trials=64, fine_factor=2),
    )


def with_body(experiment: Experiment, text: str) -> Experiment:
    """Returns an experiment with another body, and with what is derived from the body.

    Raises:
      ValueError: the text is no body that can walk here.
    """
    fresh = of_body(text)
    return dataclasses.replace(
        experiment,
        env=fresh.env,
        controller=dataclasses.replace(
            experiment.controller, **_own(experiment.controller, fresh.controller)
        ),
    )


def with_contact(experiment: Any, law: str) -> Any:
    """Returns an experiment under a contact law, "points" or "mujoco", and its usual time step.

    Raises:
      ValueError: the body has one law alone, or MJX cannot compute its contacts.
    """
    env = getattr(experiment, "env", None)
    if not isinstance(env, MjcfEnv):
        raise ValueError(
            f"{experiment.name} has one contact law; choose {NAME} or another experiment of --body"
        )
    step = defaults.of_text(env.body, contact_law=law)["timestep"]
    env = dataclasses.replace(env, contact_law=law, timestep=step)
    return dataclasses.replace(experiment, env=env)


def _own(controller: Any, fresh: Any) -> dict[str, Any]:
    own = ("period", "moved")
    return {name: getattr(fresh, name) for name in own if hasattr(controller, name)}


def _moved(env: MjcfEnv) -> Literal["legs", "all"]:
    """Returns what a policy moves at first: a walker without ankles balances by its trunk."""
    has_ankles = all(leg.ankle is not None for leg in env.anatomy.legs)
    return "legs" if has_ankles or env.anatomy.root.is_planar else "all"


WALK = of_body(reader.read(robots.path(USUAL_BODY)).text)
