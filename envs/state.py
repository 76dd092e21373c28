"""What a walker's body is between two steps."""

from typing import Any, NamedTuple

from jaxtyping import Array, Bool, Float

from mjxwalk.envs.trial import TrialState


class State(NamedTuple):
    """One walker between two steps; contacts and ankles are those that the last step saw.

    Attributes:
      qpos: the body's coordinates, m and rad; its `Anatomy` names them.
      qvel: their rates, m/s and rad/s.
      stretch: of the ground's tangential springs, m: of each contact point, along x in the plane,
        along x and y in space.
      touching: whether those points are below the ground.
      ankle_x: how far each ankle is ahead of the hip, m, left and right.
      trial: what is counted.
      own: what only this body carries, a named tuple; None of most.
    """

    qpos: Float[Array, "*batch coordinate"]
    qvel: Float[Array, "*batch coordinate"]
    stretch: Float[Array, "*batch point"] | Float[Array, "*batch point 2"]
    touching: Bool[Array, "*batch point"]
    ankle_x: Float[Array, "*batch leg"]
    trial: TrialState
    own: Any = None
