"""Linear reactive walking of Solomon, Locascio & Hartmann (2013).

"Linear reactive control for efficient 2D and 3D bipedal walking over rough terrain", Adaptive
Behavior 21(1), doi 10.1177/1059712312462904.
"""

import dataclasses

from mjxwalk.controllers import LinearReactive
from mjxwalk.envs import Planar7, RandomWalk
from mjxwalk.experiments.experiment import Experiment, StrategyChoice

PLANAR_LPD = Experiment(
    name="planar-lpd",
    env=Planar7(
        terrain=RandomWalk(roughness=0.004),  # ours: on the paper's 0.02 m nothing learns from zero
        torque_budget=6_000.0,  # ours: a good gait's half minute, so that thrift pays
        max_time=60.0,  # ours: no gait lasts that long on this budget
    ),
    controller=LinearReactive(links="local"),
    strategy=StrategyChoice(
        name="self-adaptive-ga",
        options={
            "sigma": 0.05,  # section 2.7.3
            "initial_sigma": 0.3,  # ours: the paper's is lost; walkers of smaller ones stand still
        },
    ),
    population_size=640,  # ours: the paper's 150 finds a gait in half of the seeds
    generations=60,  # ours: nearly all runs walk by then
    terrains_per_evaluation=1,  # ours: the paper's number is lost
)

PLANAR_FIL = dataclasses.replace(
    PLANAR_LPD,
    name="planar-fil",
    controller=LinearReactive(links="all"),
)
