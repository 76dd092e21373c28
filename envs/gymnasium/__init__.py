"""Gymnasium's walking tasks, version 5, to the letter, written for the engines."""

from mjxwalk.envs.gymnasium.ant import Ant
from mjxwalk.envs.gymnasium.half_cheetah import HalfCheetah
from mjxwalk.envs.gymnasium.hopper import Hopper
from mjxwalk.envs.gymnasium.humanoid import Humanoid
from mjxwalk.envs.gymnasium.state import TaskState
from mjxwalk.envs.gymnasium.task import GymnasiumTask
from mjxwalk.envs.gymnasium.told import Told
from mjxwalk.envs.gymnasium.walker2d import Walker2d

TASKS = {task.ID: task for task in (Walker2d, Hopper, HalfCheetah, Ant, Humanoid)}

__all__ = [
    "TASKS",
    "Ant",
    "GymnasiumTask",
    "HalfCheetah",
    "Hopper",
    "Humanoid",
    "TaskState",
    "Told",
    "Walker2d",
]
