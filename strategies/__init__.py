"""Evolutionary strategies as pure functions over pytrees of weights; needs JAX alone."""

from mjxwalk.strategies import links, observations, operators, ranks, vectors
from mjxwalk.strategies.ars import ARSState, ars
from mjxwalk.strategies.base import Genotype, Mask, Masks, Population, Strategy
from mjxwalk.strategies.bounds import with_bounds
from mjxwalk.strategies.clipup import ClipUpState, clipup
from mjxwalk.strategies.cma_es import CMAESState, cma_es
from mjxwalk.strategies.deep_ga import deep_ga
from mjxwalk.strategies.evaluation import evaluator
from mjxwalk.strategies.evolving_masks import (
    CarriesMasks,
    EvolvingMasksState,
    with_evolving_masks,
)
from mjxwalk.strategies.evosax import (
    EvosaxAlgorithm,
    FromEvosaxState,
    ToEvosaxState,
    from_evosax,
    to_evosax,
)
from mjxwalk.strategies.generations import GAState
from mjxwalk.strategies.hybrid_ga import HybridGAState, hybrid_ga
from mjxwalk.strategies.islands import IslandsState, with_islands
from mjxwalk.strategies.map_elites import MapElites, MapElitesMetrics, MapElitesState, map_elites
from mjxwalk.strategies.masks import MaskedState, with_mask
from mjxwalk.strategies.metrics import (
    FitnessMetrics,
    FitnessSummary,
    SearchMetrics,
    summarise_fitness,
)
from mjxwalk.strategies.observations import ObservingState, ObservingStrategy, with_observations
from mjxwalk.strategies.openai_es import OpenAIESState, openai_es
from mjxwalk.strategies.operators import Individual
from mjxwalk.strategies.pattern_search import (
    PatternSearchMetrics,
    PatternSearchState,
    pattern_search,
)
from mjxwalk.strategies.pgpe import PGPEState, pgpe
from mjxwalk.strategies.pruning import (
    PruningMetrics,
    PruningState,
    PruningStrategy,
    has_declined,
    with_pruning,
)
from mjxwalk.strategies.registry import FACTORIES, carry_over, make, register
from mjxwalk.strategies.restarting_cma_es import (
    RestartingMetrics,
    RestartingState,
    bipop_cma_es,
    ipop_cma_es,
)
from mjxwalk.strategies.restarts import RestartState, with_restarts
from mjxwalk.strategies.rewiring import RewiringMetrics, RewiringState, with_rewiring
from mjxwalk.strategies.schedules import ScheduledState, with_schedule
from mjxwalk.strategies.self_adaptive_ga import (
    SelfAdaptiveGAMetrics,
    SelfAdaptiveGAState,
    self_adaptive_ga,
)
from mjxwalk.strategies.sep_cma_es import SepCMAESState, sep_cma_es
from mjxwalk.strategies.snes import SNESState, snes
from mjxwalk.strategies.truncation_ga import truncation_ga
from mjxwalk.strategies.two_point_ga import two_point_ga
from mjxwalk.strategies.vectors import over_vectors
from mjxwalk.strategies.xnes import XNESState, xnes

__all__ = [
    "FACTORIES",
    "ARSState",
    "CMAESState",
    "CarriesMasks",
    "ClipUpState",
    "EvolvingMasksState",
    "EvosaxAlgorithm",
    "FitnessMetrics",
    "FitnessSummary",
    "FromEvosaxState",
    "GAState",
    "Genotype",
    "HybridGAState",
    "Individual",
    "IslandsState",
    "MapElites",
    "MapElitesMetrics",
    "MapElitesState",
    "Mask",
    "MaskedState",
    "Masks",
    "ObservingState",
    "ObservingStrategy",
    "OpenAIESState",
    "PGPEState",
    "PatternSearchMetrics",
    "PatternSearchState",
    "Population",
    "PruningMetrics",
    "PruningState",
    "PruningStrategy",
    "RestartState",
    "RestartingMetrics",
    "RestartingState",
    "RewiringMetrics",
    "RewiringState",
    "SNESState",
    "ScheduledState",
    "SearchMetrics",
    "SelfAdaptiveGAMetrics",
    "SelfAdaptiveGAState",
    "SepCMAESState",
    "Strategy",
    "ToEvosaxState",
    "XNESState",
    "ars",
    "bipop_cma_es",
    "carry_over",
    "clipup",
    "cma_es",
    "deep_ga",
    "evaluator",
    "from_evosax",
    "has_declined",
    "hybrid_ga",
    "ipop_cma_es",
    "links",
    "make",
    "map_elites",
    "observations",
    "openai_es",
    "operators",
    "over_vectors",
    "pattern_search",
    "pgpe",
    "ranks",
    "register",
    "self_adaptive_ga",
    "sep_cma_es",
    "snes",
    "summarise_fitness",
    "to_evosax",
    "truncation_ga",
    "two_point_ga",
    "vectors",
    "with_bounds",
    "with_evolving_masks",
    "with_islands",
    "with_mask",
    "with_observations",
    "with_pruning",
    "with_restarts",
    "with_rewiring",
    "with_schedule",
    "xnes",
]
