"""Why a trial ended, in words."""

from typing import Any, NamedTuple

import numpy as np

from mjxwalk.envs import Flame, Reil
from mjxwalk.envs.reil_body import YAW


class Ending(NamedTuple):
    """How a trial ended.

    Attributes:
      kind: "fall", "budget", "time", "slow", "broken", or "open" if it went on.
      text: the reason in a few words.
    """

    kind: str
    text: str


def explain(env: Any, state: Any, ground: float) -> Ending:
    """Returns why a trial ended, by the environment's own rules.

    Args:
      env: with the rules.
      state: that the trial ended in; numpy.
      ground: height under the hips, m.
    """
    seconds = float(state.num_steps) * env.timestep
    if not bool(state.done):
        return Ending("open", f"still walking after {seconds:.1f} s, when the recording ends")
    if bool(state.diverged):
        return Ending("broken", "the simulation broke down")
    if bool(state.fell):
        return Ending("fall", f"fell: {_fall(env, state, ground)}")
    if float(state.torque_cost) >= env.torque_budget:
        return Ending(
            "budget", f"spent its torque budget of {env.torque_budget:,.0f} N\u00a0m\u00a0s"
        )
    if isinstance(env, Reil) and float(env.hindmost(state)) >= env.max_distance:
        return Ending("time", f"came to {env.max_distance:g} m, where trials end")
    if isinstance(env, Reil) and float(state.still_time) > env.max_still_time:
        return Ending("slow", "its hips were asked to stand still")
    if int(state.num_steps) >= round(env.max_time / env.timestep):
        return Ending("time", f"walked until time was up, {env.max_time:g} s")
    return Ending("slow", f"too slow: {env.max_lag:g} m behind a pace of {env.min_speed:g} m/s")


def _fall(env: Any, state: Any, ground: float) -> str:
    if float(state.flight_time) > env.max_flight_time:
        return f"both feet in the air for over {1000 * env.max_flight_time:g} ms"
    if isinstance(env, Reil):
        turned = abs(float(state.qpos[YAW])) > env.max_yaw
        low = f"centre of mass lower than {env.min_height:.0%} of standing"
        return "turned off its course" if turned else low
    height = float(state.qpos[2 if isinstance(env, Flame) else 1]) - ground
    if height < env.min_hip_height:
        return f"hips lower than {env.min_hip_height:g} m"
    for name, value, limit in _attitude(env, state.qpos):
        if abs(value) > limit:
            return f"{name} by more than {np.degrees(limit):.0f}°"
    return "it broke a rule of its trial"


def _attitude(env: Any, qpos: Any) -> list[tuple[str, float, float]]:
    if not isinstance(env, Flame):
        pitch = float(qpos[2])
        return [("leaned forwards" if pitch > 0 else "leaned backwards", pitch, env.max_pitch)]
    yaw, pitch, roll = (float(value) for value in qpos[3:6])
    return [
        ("turned off its course", yaw, env.max_yaw),
        ("leaned forwards" if pitch > 0 else "leaned backwards", pitch, env.max_pitch),
        ("leaned sideways", roll, env.max_roll),
    ]
