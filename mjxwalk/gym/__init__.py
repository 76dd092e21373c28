"""Our bodies as tasks of reinforcement learning.

Importing it makes `gymnasium.make("mjxwalk/Planar7-v0")` and `"mjxwalk/Flame-v0"` known, and
`gymnasium.make_vec` of the same; `gymnasium.make("mjxwalk.gym:mjxwalk/Planar7-v0")` imports it by
itself. Where gymnasium is not installed, `MjxEnv` is there nevertheless.
"""

from mjxwalk.gym.mjx_env import MjxEnv, State
from mjxwalk.gym.registration import BODIES, register

register()

__all__ = ["BODIES", "MjxEnv", "State", "register"]
