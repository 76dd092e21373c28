"""The state of a Gymnasium task, and what MuJoCo tells beside positions and velocities."""

from typing import NamedTuple

from jaxtyping import Array, Float

from mjxwalk.envs.gymnasium.told import Told
from mjxwalk.envs.trial import TrialState


class TaskState(NamedTuple):
    """A body in the middle of a trial.

    Attributes:
      qpos: MuJoCo's positions; the first is how far it has come, m.
      qvel: MuJoCo's velocities.
      qacc_warmstart: accelerations near which the solver looks.
      told: what else MuJoCo's data hold.
      total: sum of the rewards so far.
      trial: what is counted, and how the trial stands; its steps are those of control.
    """

    qpos: Float[Array, " nq"]
    qvel: Float[Array, " nv"]
    qacc_warmstart: Float[Array, " nv"]
    told: Told
    total: Float[Array, ""]
    trial: TrialState
