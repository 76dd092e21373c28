"""Pushes on the torso and what it carries, once more, for walkers in C MuJoCo.

Written from docs/ground.md, not from `mjxwalk.envs`: a payload is a body of its own that is fixed
to the torso, and C MuJoCo does the rest.
"""

import numpy as np
from jaxtyping import Float

from mjxwalk.envs import LeggedEnv
from mjxwalk.envs._mujoco import compiled, mujoco
from mjxwalk.verify.herd import Herd

PAYLOAD = "payload"  # name of its body


class Own:
    """What of a body itself pushes and payloads go by.

    Attributes:
      mass: of all of it, kg.
      centre: the torso's own centre of mass, from its origin in its axes, m.
    """

    def __init__(self, env: LeggedEnv) -> None:
        """Works it out by C MuJoCo."""
        model = compiled(env.spec())
        self.mass = float(model.body_mass.sum())
        self.centre = np.array(model.body(env.anatomy.torso).ipos)


def herd(env: LeggedEnv, load: Float[np.ndarray, " walker"] | None, num: int) -> Herd:
    """Returns walkers of a body, each with its payload.

    Args:
      env: their environment.
      load: what each draws, from -1 to 1; None of those without.
      num: of walkers.
    """
    spec = env.spec()
    if not env.payload or load is None:
        return Herd(spec, num)
    own = Own(env)
    body = spec.body(env.anatomy.torso).add_body(name=PAYLOAD)
    body.explicitinertial, body.mass, body.inertia = True, 1.0, np.ones(3)
    body.ipos = np.zeros(3)
    body.pos = own.centre + (env.payload.forward, env.payload.left, env.payload.up)
    walkers = Herd(spec, num)
    model = walkers.data.model
    places = walkers.ids(PAYLOAD)[:, 0]
    model.body_mass[places] = own.mass * (env.payload.share + load * env.payload.spread)
    model.body_inertia[places] = 0.0  # about itself, as of a point
    mujoco.mj_setConst(model, walkers.data)
    return walkers


def force(
    env: LeggedEnv, own: Own, pushes: Float[np.ndarray, "walker push 3"], steps: int
) -> Float[np.ndarray, "walker 3"]:
    """Returns the average force of pushes in the step that follows so many, N.

    Args:
      env: the walkers'.
      own: of the body.
      pushes: of each walker: when they begin, s, and changes of velocity along x and y, m/s.
      steps: of the trials so far.
    """
    dt, law = env.timestep, env.push
    begin = pushes[..., 0]
    lasts = np.minimum(begin + law.duration, (steps + 1) * dt) - np.maximum(begin, steps * dt)
    share = np.maximum(lasts, 0.0) / dt
    level = (share[..., None] * pushes[..., 1:]).sum(axis=1) * own.mass / law.duration
    if env.anatomy.root.is_planar:
        level[:, 1] = 0.0
    return np.pad(level, ((0, 0), (0, 1)))
