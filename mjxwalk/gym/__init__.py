"""Our bodies as tasks of reinforcement learning.

Importing it makes `gymnasium.make("mjxwalk/NAME-v0")` and `gymnasium.make_vec` known, of every
NAME in `mjxwalk.envs.BODIES`, of every body that ships, such as H1, and Body for a user's file;
`gymnasium.make("mjxwalk.gym:mjxwalk/NAME-v0")` imports it by itself. Where gymnasium is not
installed, `MjxEnv` is there nevertheless.
"""

from mjxwalk.envs import BODIES
from mjxwalk.gym.mjx_env import MjxEnv, State
from mjxwalk.gym.registration import register

register()

__all__ = ["BODIES", "MjxEnv", "State", "register"]
