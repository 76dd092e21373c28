"""Controllers: pure functions from weights, memory and observation to an action."""

from mjxwalk.controllers.controller import Controller
from mjxwalk.controllers.ctrnn_walker import CtrnnWalker
from mjxwalk.controllers.harmonics import Harmonics
from mjxwalk.controllers.linear_feedback import LinearFeedback
from mjxwalk.controllers.linear_reactive import LinearReactive, Memory, Weights
from mjxwalk.controllers.mlp import Mlp
from mjxwalk.controllers.policy import Policy
from mjxwalk.controllers.recurrent import PatternGenerator
from mjxwalk.controllers.recurrent_network import RecurrentNetwork
from mjxwalk.controllers.spatial_reactive import SpatialReactive, SpatialWeights

__all__ = [
    "Controller",
    "CtrnnWalker",
    "Harmonics",
    "LinearFeedback",
    "LinearReactive",
    "Memory",
    "Mlp",
    "PatternGenerator",
    "Policy",
    "RecurrentNetwork",
    "SpatialReactive",
    "SpatialWeights",
    "Weights",
]
