"""Evolution of walkers: one generation, a whole run on disk, and its champion."""

from mjxwalk.evolution.elites import Elites
from mjxwalk.evolution.evolvable import Evaluator, Evolvable
from mjxwalk.evolution.generation import Evolution, RunState
from mjxwalk.evolution.loop import Reporter, evolve
from mjxwalk.evolution.measuring import Trials
from mjxwalk.experiments.goal import Goal

__all__ = [
    "Elites",
    "Evaluator",
    "Evolution",
    "Goal",
    "Reporter",
    "RunState",
    "Evolvable",
    "Trials",
    "evolve",
]
