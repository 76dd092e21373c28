"""Controllers: pure functions from weights, memory and observation to an action."""

from mjxwalk.controllers.controller import Controller
from mjxwalk.controllers.ctrnn_walker import CtrnnWalker
from mjxwalk.controllers.linear_reactive import LinearReactive, Memory, Weights
from mjxwalk.controllers.spatial_reactive import SpatialReactive, SpatialWeights

__all__ = [
    "Controller",
    "CtrnnWalker",
    "LinearReactive",
    "Memory",
    "SpatialReactive",
    "SpatialWeights",
    "Weights",
]
