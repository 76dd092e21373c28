"""Bodies, ground and the rules of a trial, simulated with MuJoCo MJX; everything for one walker."""

from mjxwalk.envs.contact import ContactForce, SoftContact
from mjxwalk.envs.joint_stop import JointStop, StopTorque
from mjxwalk.envs.planar7 import Action, Observation, Planar7, State
from mjxwalk.envs.terrain import RandomWalk, Terrain

__all__ = [
    "Action",
    "ContactForce",
    "JointStop",
    "Observation",
    "Planar7",
    "RandomWalk",
    "SoftContact",
    "State",
    "StopTorque",
    "Terrain",
]
