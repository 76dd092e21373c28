"""Controllers: pure functions from weights, memory and observation to an action."""

from mjxwalk.controllers.linear_reactive import LinearReactive, Memory, Weights
from mjxwalk.controllers.spatial_reactive import SpatialReactive, SpatialWeights

__all__ = ["LinearReactive", "Memory", "SpatialReactive", "SpatialWeights", "Weights"]
