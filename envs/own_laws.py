"""Laws that only some bodies have, as plain data, so that they can be computed by other means.

`LeggedEnv.own_laws` names the methods that hold them.
"""

from typing import NamedTuple


class Righting(NamedTuple):
    """A spring and damper about the torso's own axes that turn its vertical to the world's.

    The spring goes with the sine of the angle between them; yaw is free.

    Attributes:
      stiffness: N m/rad.
      damping: N m s/rad.
      lean: that the torso is held at, rad, forward positive.
      roll: share of both that acts sideways.
    """

    stiffness: float
    damping: float
    lean: float
    roll: float


class TorsoLoad(NamedTuple):
    """A point mass that the torso carries; trials draw from -1 to 1 of it.

    Attributes:
      mass: kg.
      offset: from the torso's origin in its axes, m.
    """

    mass: float
    offset: tuple[float, float, float]


class AlongHeading(NamedTuple):
    """Ankles are ahead of the hips where the torso heads, rather than along x."""


class LowCentre(NamedTuple):
    """Who has a centre of mass lower than this has fallen.

    It is the body's own, without its load, as the step began, over the ground under the hips then.

    Attributes:
      share: of the height over the soles when standing straight.
    """

    share: float


class Forbidden(NamedTuple):
    """Who touches the ground with a sphere about the origin of one of these bodies has fallen.

    The spheres are where they were as the step began, over the ground below their own middles.

    Attributes:
      bodies: names.
      radii: of the spheres, m.
    """

    bodies: tuple[str, ...]
    radii: tuple[float, ...]


class Arrival(NamedTuple):
    """Who has come so far with the hindmost ankle has arrived, m."""

    distance: float


class Standstill(NamedTuple):
    """A trial ends when what is asked of the motors has stood still.

    Attributes:
      rate: below which it does, rad/s; before the first step all that is asked counts as 0.
      time: for which it may, s.
    """

    rate: float
    time: float


class HindmostAnkle(NamedTuple):
    """Fitness is how far the hindmost ankle has come.

    Attributes:
      fallen_distance: who fell before has fitness 0, m.
    """

    fallen_distance: float
