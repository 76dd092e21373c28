"""Evolution of walkers: one generation, a whole run on disk, and its champion."""

from mjxwalk.evolution.generation import Elites, Evaluator, Evolution, Evolvable, RunState
from mjxwalk.evolution.goal import Goal
from mjxwalk.evolution.loop import Reporter, evolve
from mjxwalk.evolution.measuring import Trials

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
