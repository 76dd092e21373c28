"""Linear reactive walking of Solomon, Locascio & Hartmann (2013).

"Linear reactive control for efficient 2D and 3D bipedal walking over rough terrain", Adaptive
Behavior 21(1), doi 10.1177/1059712312462904.
"""

import dataclasses

from mjxwalk.controllers import LinearReactive
from mjxwalk.envs import Planar7, RandomWalk
from mjxwalk.evolution import Goal
from mjxwalk.experiments.experiment import Experiment, StrategyChoice

PLANAR_LPD = Experiment(
    name="planar-lpd",
    env=Planar7(
        terrain=RandomWalk(roughness=0.004),  # ours: on the paper's 0.02 m nothing learns from zero
        torque_budget=8_000.0,  # ours: buys a gait 30 to 50 s; much more makes them run
        max_time=60.0,  # ours: standing still costs little
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
    generations=400,  # ours: many times what most seeds take
    terrains_per_evaluation=1,  # ours: the paper's number is lost
    goal=Goal(trials=500, duration=30.0, distance=20.0),  # ours: as good as never falls
    restart_after=40,  # ours: who walks at all does by then
    restart_below=10.0,  # ours: m; lunges end at 2 m, a few steps at 6 m
    restart_at=100,  # ours: most reach the goal after 40 to 80
)

PLANAR_FIL = dataclasses.replace(
    PLANAR_LPD,
    name="planar-fil",
    controller=LinearReactive(links="all"),
    goal=Goal(),
    restart_at=None,
    generations=200,  # ours: from zero most seeds do not walk; from an LPD walker they would
)
