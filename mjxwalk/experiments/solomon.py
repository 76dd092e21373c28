"""Linear reactive walking of Solomon, Locascio & Hartmann (2013), in the plane.

"Linear reactive control for efficient 2D and 3D bipedal walking over rough terrain", Adaptive
Behavior 21(1), doi 10.1177/1059712312462904; sections 2.2 and 2.7.
"""

import dataclasses

from mjxwalk.controllers import LinearReactive
from mjxwalk.envs import Planar7, RandomWalk
from mjxwalk.evolution import Goal
from mjxwalk.experiments.experiment import Experiment, StrategyChoice
from mjxwalk.experiments.pruning import Pruning
from mjxwalk.experiments.ramp import RoughnessRamp
from mjxwalk.experiments.study import Study

SLIGHT_ROUGHNESS = 0.004  # m; ours: on the paper's 0.02 m nothing learns from zero
PAPER_ROUGHNESS = 0.02  # m; section 2.2, 5.4 % of leg length over a step

PLANAR_LPD = Experiment(
    name="planar-lpd",
    env=Planar7(
        terrain=RandomWalk(roughness=SLIGHT_ROUGHNESS),
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
    # ours: as good as never falls, and not only at the time step that it evolved at
    goal=Goal(trials=500, duration=30.0, distance=20.0, fine_trials=50),
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

# The study's settings that the paper does not leave us, all in one place.
FIL_BUDGET = 3_000.0  # N m s; ours: the 2D budget is lost; buys an efficient gait about 20 m
LPD_BUDGET = 3 * FIL_BUDGET  # section 2.7.2
MAX_TIME = 100.0  # s; ours: longer than the budget lasts a walker that walks
INITIAL_SIGMA = 0.3  # ours: as for planar-lpd
RAMP = RoughnessRamp(start=SLIGHT_ROUGHNESS, generations=300)  # ours: as far as LPD learns to walk
RESTART_AFTER, RESTART_BELOW = 40, 10.0  # generations and m; ours: as for planar-lpd
MOST_PRUNING = 1_500  # generations; ours: the paper's took at most 854 and 200 to settle
# ours: as many as in the paper, which of them is lost; chosen by what senses seem to tell.
RSIL_LINKS = {
    "torso": ("stance thigh", "inter-leg", "stance thigh rate", "inter-leg rate"),
    "inter-leg": ("torso", "stance thigh", "torso rate", "stance thigh rate"),
    "stance ankle": (
        "torso",
        "stance thigh",
        "inter-leg",
        "stance knee",
        "torso rate",
        "stance thigh rate",
        "inter-leg rate",
    ),
}


def _lpd(study: str) -> Experiment:
    return Experiment(
        name=f"{study}/lpd",
        env=Planar7(
            terrain=RandomWalk(roughness=PAPER_ROUGHNESS),
            torque_budget=LPD_BUDGET,
            max_time=MAX_TIME,
        ),
        controller=LinearReactive(links="local"),
        strategy=StrategyChoice(
            name="self-adaptive-ga",
            options={
                "sigma": 0.05,  # section 2.7.3
                "initial_sigma": INITIAL_SIGMA,
            },
        ),
        population_size=150,  # section 2.7.3
        generations=500,  # section 2.7.3
        terrains_per_evaluation=1,  # ours: the paper's number is lost
        restart_after=RESTART_AFTER,
        restart_below=RESTART_BELOW,
        ramp=RAMP,
    )


def _fil(name: str, lpd: Experiment, controller: LinearReactive) -> Experiment:
    """Returns the phase that starts around the winner of LPD, with more links."""
    return dataclasses.replace(
        lpd,
        name=name,
        env=dataclasses.replace(lpd.env, torque_budget=FIL_BUDGET),
        controller=controller,
        strategy=StrategyChoice(
            name="self-adaptive-ga",
            options={
                "sigma": 0.005,  # section 2.7.3
                "initial_sigma": 0.05,  # section 2.7.3
            },
        ),
        generations=3_000,  # section 2.7.3
        start="winner",
        ramp=None,
        restart_after=None,
    )


def _sil(study: str, fil: Experiment) -> Experiment:
    return dataclasses.replace(
        fil,
        name=f"{study}/sil",
        start="population",
        generations=MOST_PRUNING,
        pruning=Pruning(),
    )


def _three_phases(study: str, lpd: Experiment) -> Study:
    fil = _fil(f"{study}/fil", lpd, LinearReactive(links="all"))
    return Study(name=study, phases=(("lpd", lpd), ("fil", fil), ("sil", _sil(study, fil))))


def _reduced(study: str) -> Study:
    lpd = _lpd(study)
    rsil = _fil(f"{study}/rsil", lpd, LinearReactive(links=RSIL_LINKS))
    return Study(name=study, phases=(("lpd", lpd), ("rsil", rsil)))


SOLOMON_2D = _three_phases("solomon-2d", _lpd("solomon-2d"))
SOLOMON_2D_RSIL = _reduced("solomon-2d-rsil")
SOLOMON_2D_LITERAL = _three_phases(
    "solomon-2d-literal",
    dataclasses.replace(_lpd("solomon-2d-literal"), ramp=None, restart_after=None),
)
