"""Why a trial ended, in words."""

from typing import Any, NamedTuple

import numpy as np

TILTS = {  # what a tilt beyond its limit is called, where it is positive and where it is negative
    "yaw": ("turned off its course", "turned off its course"),
    "pitch": ("leaned forwards", "leaned backwards"),
    "roll": ("leaned sideways", "leaned sideways"),
}


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
      env: a `LeggedEnv`.
      state: that the trial ended in; numpy.
      ground: height under the hips, m.
    """
    trial = state.trial
    seconds = float(trial.num_steps) * env.timestep
    if not bool(trial.done):
        return Ending("open", f"still walking after {seconds:.1f} s, when the recording ends")
    if bool(trial.diverged):
        return Ending("broken", "the simulation broke down")
    if bool(trial.fell):
        return Ending("fall", f"fell: {_fall(env, state, ground)}")
    if float(trial.torque_cost) >= env.torque_budget:
        return Ending(
            "budget", f"spent its torque budget of {env.torque_budget:,.0f} N\u00a0m\u00a0s"
        )
    own = env.over_words(state)
    if own is not None:
        return own
    if int(trial.num_steps) >= round(env.max_time / env.timestep):
        return Ending("time", f"walked until time was up, {env.max_time:g} s")
    return Ending("slow", f"too slow: {env.max_lag:g} m behind a pace of {env.min_speed:g} m/s")


def _fall(env: Any, state: Any, ground: float) -> str:
    if float(state.trial.flight_time) > env.max_flight_time:
        return f"both feet in the air for over {1000 * env.max_flight_time:g} ms"
    if bool(env.is_low(state, ground)):
        return env.low_words()
    for turn, limit in env.max_tilt.items():
        value = float(state.qpos[getattr(env.anatomy.root, turn)])
        if abs(value) > limit:
            return f"{TILTS[turn][value < 0]} by more than {np.degrees(limit):.0f}°"
    return "it broke a rule of its trial"
