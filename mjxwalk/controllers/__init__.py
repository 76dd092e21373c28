"""Controllers: pure functions from weights, memory and observation to an action."""

from mjxwalk.controllers.linear_reactive import LinearReactive, Memory, Weights

__all__ = ["LinearReactive", "Memory", "Weights"]
