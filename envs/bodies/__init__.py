"""The bodies that come with mjxwalk, each an MJCF file with its settings."""

from collections.abc import Callable, Mapping

from mjxwalk.envs.bodies.flame import Flame
from mjxwalk.envs.bodies.planar7 import Planar7
from mjxwalk.envs.bodies.reil import Reil
from mjxwalk.envs.legged import LeggedEnv

BODIES: Mapping[str, Callable[[], LeggedEnv]] = {
    each.__name__: each for each in (Planar7, Flame, Reil)
}

__all__ = ["BODIES", "Flame", "Planar7", "Reil"]
