"""What the biped of Reil & Massey is asked, and what only it carries between two steps.

Source as in `reil.py`.
"""

from typing import NamedTuple

from jaxtyping import Array, Float


class HipTargets(NamedTuple):
    """What a controller asks of the motors.

    Attributes:
      target: desired pitch of the left and the right hip, rad, forward positive.
    """

    target: Float[Array, "2"]


class ReilState(NamedTuple):
    """What only this body carries.

    Attributes:
      height: of the centre of mass over the ground, m.
      target: last desired angles of the hips, rad.
      still_time: since one of them last changed, s.
    """

    height: Float[Array, "*batch"]
    target: Float[Array, "*batch 2"]
    still_time: Float[Array, "*batch"]
