"""Evolutionary strategies as pure functions over pytrees of weights; needs JAX alone."""

from mjxwalk.strategies import operators
from mjxwalk.strategies.base import Genotype, Mask, Masks, Population, Strategy
from mjxwalk.strategies.metrics import FitnessSummary, summarise_fitness
from mjxwalk.strategies.operators import Individual
from mjxwalk.strategies.registry import FACTORIES, make
from mjxwalk.strategies.restarts import RestartState, with_restarts
from mjxwalk.strategies.self_adaptive_ga import (
    SelfAdaptiveGAMetrics,
    SelfAdaptiveGAState,
    self_adaptive_ga,
)

__all__ = [
    "FACTORIES",
    "FitnessSummary",
    "Genotype",
    "Individual",
    "Mask",
    "Masks",
    "Population",
    "RestartState",
    "SelfAdaptiveGAMetrics",
    "SelfAdaptiveGAState",
    "Strategy",
    "make",
    "operators",
    "self_adaptive_ga",
    "summarise_fitness",
    "with_restarts",
]
