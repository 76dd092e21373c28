"""Usual settings of any body, derived from its weight and its size."""

from typing import Any

import numpy as np

from mjxwalk.envs.contact import SoftContact
from mjxwalk.envs.derived import anatomy, file_tree, source
from mjxwalk.envs.fitness_terms import FitnessTerms
from mjxwalk.envs.joint_stop import JointStop

# ours: shares of a body's weight, of the height of its root, and of the time that a fall from there
# takes, over the square root of two. Each is what let the first few bodies walk.
SINK = 0.004  # of four points of the feet that carry it, in heights
STOP_STIFFNESS = 4.0  # of joints' limits, in weights times heights a rad
STOP_TIME = 0.04  # of their damping over their stiffness
STEP = 0.011  # of the physics
SPEED = 0.28  # that is wanted
LEAST_SPEED = 0.14  # below which a walker falls behind
MOST_LAG = 2.0  # heights that it may fall behind
FLIGHT = 0.12  # without ground contact; with more, walkers hop at push-off
# What a second at the wanted speed is worth, beside 1 for not falling, and costs: sideways, and by
# a cost of transport of 1.
DISTANCE_WORTH, DRIFT_COST, WORK_COST = 0.44, 0.26, 0.09
MOST_FRICTION = 1.0  # a file's feet may say more, and ground like that is rare
CLEARANCE = 0.05  # of a foot in the air, that is wanted
FINEST, COARSEST = 0.0005, 0.002  # s; of the physics


def of_text(text: str, *, contact_law: str) -> dict[str, Any]:
    """Returns settings of an `MjcfEnv` by name.

    Args:
      text: MJCF of the body, in itself complete.
      contact_law: "points" or "mujoco", which takes the file's time step.

    Raises:
      ValueError: the text is no body that can be simulated.
    """
    found = anatomy.stance(text)
    height, weight, time = found.height, found.weight, found.time
    stiffness = weight / (4 * SINK * height)
    mass = weight / anatomy.GRAVITY
    stop = STOP_STIFFNESS * weight * height
    pace = height / time
    step = float(np.clip(_rounded(STEP * time, 1), FINEST, COARSEST))
    if contact_law == "mujoco":
        step = float(source.model(text).opt.timestep)
    return {
        "contact": SoftContact(
            stiffness=_rounded(stiffness),
            damping=_rounded(np.sqrt(stiffness * mass / 4)),
            friction=_rounded(min(MOST_FRICTION, file_tree.friction(text))),
        ),
        "joint_stop": JointStop(
            stiffness=_rounded(stop), damping=_rounded(STOP_TIME * time * stop)
        ),
        "timestep": step,
        "max_flight_time": _rounded(FLIGHT * time),
        "min_speed": _rounded(LEAST_SPEED * pace),
        "max_lag": _rounded(MOST_LAG * height),
        "terms": FitnessTerms(
            speed=_rounded(SPEED * pace),
            clear_height=_rounded(CLEARANCE * height),
            distance=_rounded(DISTANCE_WORTH / (SPEED * pace)),
            drift=_rounded(-DRIFT_COST / (SPEED * pace)),
            work=_rounded(-WORK_COST * height / (SPEED * pace)),
        ),
    }


def _rounded(value: float, digits: int = 2) -> float:
    """Returns a number with so many digits, so that settings are read easily."""
    return float(f"{value:.{digits}g}")
