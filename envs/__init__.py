"""Bodies, ground and the rules of a trial, simulated with MuJoCo MJX; everything for one walker."""

from mjxwalk.envs.contact import ContactForce, SoftContact
from mjxwalk.envs.flame import Flame
from mjxwalk.envs.joint_stop import JointStop, StopTorque
from mjxwalk.envs.motor import Action
from mjxwalk.envs.planar7 import Observation, Planar7, State
from mjxwalk.envs.surface import SerpentineWalk
from mjxwalk.envs.terrain import RandomWalk, Terrain

__all__ = [
    "Action",
    "ContactForce",
    "Flame",
    "JointStop",
    "Observation",
    "Planar7",
    "RandomWalk",
    "SerpentineWalk",
    "SoftContact",
    "State",
    "StopTorque",
    "Terrain",
]
