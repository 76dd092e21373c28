"""Evolution of walkers: one generation, a whole run on disk, and its champion."""

from mjxwalk.evolution.elites import Elites
from mjxwalk.evolution.evolvable import Evaluator, Evolvable
from mjxwalk.evolution.generation import Evolution, RunState
from mjxwalk.evolution.loop import evolve
from mjxwalk.evolution.recorder import Recorder, RunRecorder
from mjxwalk.experiments.goal import Goal
from mjxwalk.progress import Reporter

__all__ = [
    "Elites",
    "Evaluator",
    "Evolution",
    "Goal",
    "Recorder",
    "Reporter",
    "RunRecorder",
    "RunState",
    "Evolvable",
    "evolve",
]
