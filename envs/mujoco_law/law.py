"""Contact law `mujoco` of a body of a file: MuJoCo's step, in the coordinates of its anatomy."""

from typing import Any

import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs.mujoco_law import model as mujoco_model
from mjxwalk.envs.mujoco_law import step as mujoco_step
from mjxwalk.envs.mujoco_law.coordinates import Coordinates
from mjxwalk.envs.mujoco_law.ground import Under
from mjxwalk.envs.mujoco_law.model import MujocoModel
from mjxwalk.envs.mujoco_law.step import MujocoState, Report
from mjxwalk.envs.state import State
from mjxwalk.envs.trial import Trial


def model_of(env: Any) -> MujocoModel:
    """Returns the model of an environment's body.

    Raises:
      ValueError: MJX cannot compute its contacts or constraints, or it is pushed or loaded.
    """
    for name in ("push", "payload"):
        if getattr(env, name):
            raise ValueError(
                f'{name} must be none where contact_law is "mujoco", which does not know it; take '
                'contact_law "points" for it'
            )
    return mujoco_model.of_text(env.body, env.solver, env.timestep)


def begin(
    env: Any, qpos: Float[Array, " coordinate"], qvel: Float[Array, " coordinate"]
) -> MujocoState:
    """Returns what MuJoCo carries of a body at the start of a trial."""
    return mujoco_step.begin(model_of(env), Coordinates(qpos, qvel))


def step(
    env: Any, state: State, action: Any, given: Trial
) -> tuple[Coordinates, MujocoState, Report]:
    """Returns where the body is a step later, what MuJoCo carries, and what happened.

    Args:
      env: an `MjcfEnv`.
      state: before the step.
      action: an `Action`.
      given: the trial.
    """
    model = model_of(env)

    def ground(x: Float[Array, ""], y: Float[Array, ""] | None) -> Under:
        here = env.course.under(given.ground, x)
        height = env.ground_height(given, x, y)
        if here is None:
            return Under(height)
        stiffness, friction = (None, None) if here.footing is None else here.footing
        return Under(height, here.gradient, stiffness, friction)

    after, report = mujoco_step.step(model, state.own.mujoco, action, ground)
    return mujoco_step.coordinates(model, after), after, report


def of_points(env: Any, of_legs: Any) -> Any:
    """Returns a value of each leg as one of each of its contact points."""
    anatomy = env.anatomy
    legs = np.zeros(len(anatomy.points), int)
    for place, leg in enumerate(anatomy.legs):
        legs[anatomy.points_of(leg)] = place
    return of_legs[legs]
