"""Motors of our own bodies that go to targets, where a policy is to ask for them."""

from typing import Any

import jax
import numpy as np
from jaxtyping import Float

from mjxwalk.envs.anatomy import Anatomy, Motor
from mjxwalk.envs.derived.motors import usual_gains


def rest(env: Any) -> Float[np.ndarray, " coordinate"]:
    """Returns coordinates as trials start, m and rad, the mean of both sides where these differ."""
    with jax.ensure_compile_time_eval():
        qpos = np.asarray(env.start(env.level_trials().given(0)).qpos)
    coordinates = env.anatomy.coordinates
    sign = np.array([each.sign for each in coordinates], np.float32)
    return 0.5 * (qpos + sign * qpos[np.array([each.mirror for each in coordinates])])


def holding(env: Any) -> Anatomy:
    """Returns a body's anatomy with motors that go to targets about where its joints rest.

    They have the gains that motors of a file have where it has none; see docs/any-body.md.
    """
    places, usual = rest(env), env.weight * env.leg_length
    motors: list[Motor] = []
    for each in env.anatomy.motors:
        stiffness, damping = usual_gains(each.highest, usual, env.walking_time)
        motor = each._replace(law="position", stiffness=stiffness, damping=damping)
        motors.append(motor._replace(strength=1.0, centre=float(places[each.coordinate])))
    return env.anatomy._replace(motors=tuple(motors))
