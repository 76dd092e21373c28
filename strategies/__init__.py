"""Evolutionary strategies as pure functions over pytrees of weights; needs JAX alone."""

from mjxwalk.strategies import links, operators
from mjxwalk.strategies.base import Genotype, Mask, Masks, Population, Strategy
from mjxwalk.strategies.metrics import FitnessSummary, summarise_fitness
from mjxwalk.strategies.operators import Individual
from mjxwalk.strategies.pruning import (
    PruningMetrics,
    PruningState,
    PruningStrategy,
    has_declined,
    with_pruning,
)
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
    "PruningMetrics",
    "PruningState",
    "PruningStrategy",
    "RestartState",
    "SelfAdaptiveGAMetrics",
    "SelfAdaptiveGAState",
    "Strategy",
    "has_declined",
    "links",
    "make",
    "operators",
    "self_adaptive_ga",
    "summarise_fitness",
    "with_pruning",
    "with_restarts",
]
