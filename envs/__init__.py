"""Bodies, ground and the rules of a trial, simulated with MuJoCo MJX; everything for one walker."""

from mjxwalk.envs.anatomy import Anatomy
from mjxwalk.envs.bodies import BODIES, Flame, Planar7, Reil
from mjxwalk.envs.bodies.reil_state import HipTargets
from mjxwalk.envs.bodies.reil_trials import TrialVariation
from mjxwalk.envs.contact import ContactForce, SoftContact
from mjxwalk.envs.course import Course
from mjxwalk.envs.course_parts import Gaps, Slope, Stairs, Stretches
from mjxwalk.envs.fitness_terms import FitnessTerms
from mjxwalk.envs.flat_env import FlatEnv
from mjxwalk.envs.joint_stop import JointStop, StopTorque
from mjxwalk.envs.legged import LeggedEnv
from mjxwalk.envs.mjcf_env import MjcfEnv
from mjxwalk.envs.motor import Action
from mjxwalk.envs.observation import BodyObservation, PlanarObservation, SpatialObservation
from mjxwalk.envs.payload import Payload
from mjxwalk.envs.push import Push
from mjxwalk.envs.state import State
from mjxwalk.envs.surface import SerpentineWalk
from mjxwalk.envs.terrain import RandomWalk, Terrain
from mjxwalk.envs.trial import TRIAL_AXES, Trial, Trials, TrialState
from mjxwalk.envs.velocity_motor import VelocityMotor

__all__ = [
    "BODIES",
    "TRIAL_AXES",
    "Action",
    "Anatomy",
    "BodyObservation",
    "ContactForce",
    "Course",
    "Flame",
    "FitnessTerms",
    "FlatEnv",
    "Gaps",
    "HipTargets",
    "JointStop",
    "LeggedEnv",
    "MjcfEnv",
    "Payload",
    "PlanarObservation",
    "Planar7",
    "Push",
    "RandomWalk",
    "Reil",
    "SerpentineWalk",
    "Slope",
    "SoftContact",
    "SpatialObservation",
    "Stairs",
    "State",
    "StopTorque",
    "Stretches",
    "Terrain",
    "Trial",
    "TrialState",
    "TrialVariation",
    "Trials",
    "VelocityMotor",
]
