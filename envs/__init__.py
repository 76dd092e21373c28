"""Bodies, ground and the rules of a trial, simulated with MuJoCo MJX; everything for one walker."""

from mjxwalk.envs.contact import ContactForce, SoftContact
from mjxwalk.envs.flame import Flame
from mjxwalk.envs.joint_stop import JointStop, StopTorque
from mjxwalk.envs.motor import Action
from mjxwalk.envs.planar7 import Observation, Planar7, State
from mjxwalk.envs.reil import HipTargets, Reil
from mjxwalk.envs.reil_trials import TrialVariation
from mjxwalk.envs.surface import SerpentineWalk
from mjxwalk.envs.terrain import RandomWalk, Terrain
from mjxwalk.envs.velocity_motor import VelocityMotor

__all__ = [
    "Action",
    "ContactForce",
    "Flame",
    "HipTargets",
    "JointStop",
    "Observation",
    "Planar7",
    "RandomWalk",
    "Reil",
    "SerpentineWalk",
    "SoftContact",
    "State",
    "StopTorque",
    "Terrain",
    "TrialVariation",
    "VelocityMotor",
]
