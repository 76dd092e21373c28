"""Evolutionary strategies as pure functions over pytrees of weights; needs JAX alone."""

from mjxwalk.strategies import links, operators
from mjxwalk.strategies.base import Genotype, Mask, Masks, Population, Strategy
from mjxwalk.strategies.hybrid_ga import HybridGAState, hybrid_ga
from mjxwalk.strategies.metrics import FitnessSummary, summarise_fitness
from mjxwalk.strategies.operators import Individual
from mjxwalk.strategies.pattern_search import (
    PatternSearchMetrics,
    PatternSearchState,
    pattern_search,
)
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
from mjxwalk.strategies.two_point_ga import TwoPointGAState, two_point_ga

__all__ = [
    "FACTORIES",
    "FitnessSummary",
    "Genotype",
    "HybridGAState",
    "Individual",
    "Mask",
    "Masks",
    "Population",
    "PatternSearchMetrics",
    "PatternSearchState",
    "PruningMetrics",
    "PruningState",
    "PruningStrategy",
    "RestartState",
    "SelfAdaptiveGAMetrics",
    "SelfAdaptiveGAState",
    "Strategy",
    "TwoPointGAState",
    "has_declined",
    "hybrid_ga",
    "links",
    "make",
    "operators",
    "pattern_search",
    "self_adaptive_ga",
    "summarise_fitness",
    "two_point_ga",
    "with_pruning",
    "with_restarts",
]
