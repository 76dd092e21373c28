"""Linear reactive walking of Solomon, Locascio & Hartmann (2013), in space.

"Linear reactive control for efficient 2D and 3D bipedal walking over rough terrain", Adaptive
Behavior 21(1), doi 10.1177/1059712312462904; sections 2.7 and 3.5.
"""

from mjxwalk.controllers import SpatialReactive
from mjxwalk.envs import Flame
from mjxwalk.evolution import Goal
from mjxwalk.experiments.experiment import Experiment, StrategyChoice

SOLOMON_3D = Experiment(
    name="solomon-3d",
    env=Flame(),  # on slightly rough ground, r = 0.002 m, with 1,000 N m s
    controller=SpatialReactive(),
    strategy=StrategyChoice(
        name="self-adaptive-ga",
        options={
            "sigma": 0.05,  # section 2.7.3
            "initial_sigma": 0.2,  # ours
            "num_elites": 0,  # section 3.5.1: no elitism
            "minimum_learning_rate": 0.3,  # ours: lower rates settle on lunges
        },
    ),
    population_size=640,  # ours
    generations=400,  # ours
    terrains_per_evaluation=1,  # ours: the paper's number is lost
    goal=Goal(trials=100, distance=50.0),
)
