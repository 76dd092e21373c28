"""What a step of walkers in C MuJoCo goes by, and what it saw."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.verify.laws import GroundForce


class Step(NamedTuple):
    """What a step saw and gave.

    Attributes:
      push: of the ground.
      feet: where the feet's bodies were, m.
      centre: where the centre of mass was, m.
      torque: of the motors, N m.
      rate: of their coordinates after the step, rad/s.
    """

    push: GroundForce
    feet: Float[np.ndarray, "walker leg 3"]
    centre: Float[np.ndarray, "walker 3"]
    torque: Float[np.ndarray, "walker motor"]
    rate: Float[np.ndarray, "walker motor"]


class Balance(NamedTuple):
    """What the joints' accelerations follow from; laws add to it in place.

    Attributes:
      mass: N s^2/m or N m s^2.
      force: N or N m.
    """

    mass: Float[np.ndarray, "walker joint joint"]
    force: Float[np.ndarray, "walker joint"]
