"""Evolution of a study's walkers: one generation, a whole run on disk, and its champion."""

from mjxwalk.evolution.generation import Elites, Evaluator, Evolution, RunState, Study
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
    "Study",
    "Trials",
    "evolve",
]
