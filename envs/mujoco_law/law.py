"""Contact law `mujoco` of a body of a file: MuJoCo's step, in the coordinates of its anatomy."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import trial
from mjxwalk.envs.dynamics import PointMass
from mjxwalk.envs.mujoco_law import model as mujoco_model
from mjxwalk.envs.mujoco_law import step as mujoco_step
from mjxwalk.envs.mujoco_law.coordinates import Coordinates
from mjxwalk.envs.mujoco_law.forward import TORSO, Burden, MujocoState
from mjxwalk.envs.mujoco_law.ground import Under
from mjxwalk.envs.mujoco_law.model import MujocoModel
from mjxwalk.envs.mujoco_law.report import Report
from mjxwalk.envs.state import State
from mjxwalk.envs.trial import Trial


def model_of(env: Any) -> MujocoModel:
    """Returns the model of an environment's body.

    Raises:
      ValueError: MJX cannot compute its contacts or constraints.
    """
    return mujoco_model.of_text(env.body, env.solver, env.timestep)


def begin(
    env: Any, qpos: Float[Array, " coordinate"], qvel: Float[Array, " coordinate"]
) -> MujocoState:
    """Returns what MuJoCo carries of a body at the start of a trial."""
    return mujoco_step.begin(model_of(env), Coordinates(qpos, qvel))


def step(env: Any, state: State, action: Any, given: Trial) -> State:
    """Returns the walker one physics step later; terms and ends are not counted yet.

    Args:
      env: an `MjcfEnv`.
      state: before the step.
      action: an `Action`.
      given: the trial.
    """
    at, after, report = _stepped(env, state, action, given)
    touching = _of_points(env, report.touching)
    return state._replace(
        qpos=at.qpos,
        qvel=at.qvel,
        touching=touching,
        ankle_x=report.foot[:, 0],
        trial=trial.count(
            env,
            state.trial,
            touching=touching,
            torque=report.torque,
            rate=at.qvel[env.anatomy.driven],
        ),
        own=state.own._replace(mujoco=after),
    )


def ground_forces(env: Any, state: State, idle: Any, given: Trial) -> Float[Array, "point 3"]:
    """Returns the ground's force on each contact point, N; a foot's is shared by its points.

    Args:
      env: an `MjcfEnv`.
      state: of the walker.
      idle: the `Action` that asks for nothing.
      given: the trial.
    """
    _, _, report = _stepped(env, state, idle, given)
    shares = [1.0 / len(env.anatomy.points_of(leg)) for leg in env.anatomy.legs]
    return _of_points(env, report.force * jnp.array(shares)[:, None])


def _stepped(
    env: Any, state: State, action: Any, given: Trial
) -> tuple[Coordinates, MujocoState, Report]:
    """Returns where the body is a step later, what MuJoCo carries, and what happened."""
    model = model_of(env)

    def ground(x: Float[Array, ""], y: Float[Array, ""] | None) -> Under:
        here = env.course.under(given.ground, x)
        height = env.ground_height(given, x, y)
        if here is None:
            return Under(height)
        stiffness, friction = (None, None) if here.footing is None else here.footing
        return Under(height, here.gradient, stiffness, friction)

    burden = _burden(env, model, state, given)
    after, report = mujoco_step.step(model, state.own.mujoco, action, ground, burden)
    return mujoco_step.coordinates(model, after), after, report


def _burden(env: Any, model: MujocoModel, state: State, given: Trial) -> Burden:
    """Returns what a trial puts on the torso in the step after a state."""
    load, push = None, None
    if env.payload and given.load is not None:
        offset = model.turn.T @ np.array(env.payload.offset)  # in the axes of the file's root
        place = np.asarray(model.mujoco.body_ipos[TORSO] + offset, np.float32)
        load = PointMass(TORSO, place, env.payload.mass(given.load, env.mass))
    if env.push and given.push is not None:
        change = env.push.acceleration(given.push, state.trial.num_steps, env.timestep)
        if model.planar:
            change = change.at[1].set(0.0)
        push = jnp.append(env.mass * change, 0.0)
    return Burden(load, push)


def _of_points(env: Any, of_legs: Any) -> Any:
    """Returns a value of each leg as one of each of its contact points."""
    anatomy = env.anatomy
    legs = np.zeros(len(anatomy.points), int)
    for place, leg in enumerate(anatomy.legs):
        legs[anatomy.points_of(leg)] = place
    return of_legs[legs]
