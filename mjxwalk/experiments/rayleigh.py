"""The thesis' four oscillators fitted to human walking, and an oscillator for each harmonic."""

import dataclasses

from mjxwalk.controllers.patterns import FourJoints, HarmonicLegs
from mjxwalk.experiments.experiment import StrategyChoice
from mjxwalk.experiments.rayleigh_fit import GENERATIONS, RayleighFit

STRATEGY = StrategyChoice(
    name="hybrid-ga",
    options={"breeding_generations": GENERATIONS, "initial_mesh": 0.125},
)
RAYLEIGH = RayleighFit(
    name="rayleigh",
    network=FourJoints(),
    strategy=STRATEGY,
    generations=GENERATIONS + 200,  # ours: of the pattern search; its mesh is then at its limit
)
RAYLEIGH_HARMONIC = RayleighFit(
    name="rayleigh-harmonic",
    network=HarmonicLegs(),
    strategy=dataclasses.replace(
        STRATEGY, options={"breeding_generations": 100, "initial_mesh": 0.125}
    ),
    settling_cycles=10,  # ours: the harmonics have then locked to the first
    cycles=3,
    generations=1000,
)
