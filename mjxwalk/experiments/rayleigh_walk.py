"""The fitted oscillators put to work: they drive the planar walker's hips and knees.

Ours: the thesis of `mjxwalk.experiments.rayleigh` has no body.
"""

from mjxwalk.controllers.rayleigh_walker import RayleighWalker
from mjxwalk.envs import Planar7, RandomWalk
from mjxwalk.experiments.experiment import Experiment, StrategyChoice

RAYLEIGH_WALK = Experiment(
    name="rayleigh-walk",
    env=Planar7(
        # ours: on flat ground every trial is the same, and what evolves falls on any other
        terrain=RandomWalk(roughness=0.004),
        torque_budget=8_000.0,  # ours: as planar-lpd
        max_time=60.0,
    ),
    controller=RayleighWalker(),
    strategy=StrategyChoice(
        name="self-adaptive-ga", options={"sigma": 0.05, "initial_sigma": 0.15}
    ),
    population_size=320,
    generations=150,
    terrains_per_evaluation=2,
)
