"""A pattern generator that walks a biped with powered hips only, after Reil & Massey (2001).

"Facilitating controller evolution in morpho-functional machines - a bipedal case study", sections
3.2, 4.3 and 5. What the paper leaves open is marked as ours; docs/reil.md tells what was tried.
"""

import dataclasses

from mjxwalk.controllers import CtrnnWalker
from mjxwalk.envs import Reil, TrialVariation
from mjxwalk.experiments.experiment import Experiment, StrategyChoice
from mjxwalk.experiments.goal import Goal
from mjxwalk.experiments.study import Study

MILESTONE = 20.0  # m; section 5
# ours, all four: a weak hand; docs/reil.md tells what else was tried.
ASSISTANCE = 200.0  # N m/rad; less than the trunk's weight would need
ASSISTANCE_DAMPING = 40.0  # N m s/rad
ASSISTANCE_LEAN = 0.8  # rad; as the body walks without
ASSISTANCE_ROLL = 0.1  # share; who is held upright sideways cannot lift a foot by leaning
# ours: as far from the usual start as the tournament's perturbed starts, and as much for body and
# ground; who has walked from all of these repeats none by heart.
VARIATION = TrialVariation(
    push=0.1, sideways=0.05, pitch_rate=0.1, stride=0.05, load=3.0, slope=0.003
)
TRIALS = 8  # ours: of each genotype in a generation, where trials differ
POPULATION = 100  # section 3.2
SENSE = 4.0  # ours: a quarter of the largest weight

REIL_UNASSISTED = Experiment(
    name="reil-unassisted",
    env=Reil(),
    controller=CtrnnWalker(),
    strategy=StrategyChoice(name="truncation-ga", options={"lower": -1.0, "upper": 1.0}),
    population_size=POPULATION,
    generations=200,  # ours: twice the paper's hundred
    terrains_per_evaluation=1,
    goal=Goal(trials=1, distance=MILESTONE),
)


def _assisted(study: str) -> Experiment:
    """Returns the phase in which the trunk is righted, until one walker reaches 20 m."""
    return dataclasses.replace(
        REIL_UNASSISTED,
        name=f"{study}/assisted",
        env=Reil(
            assistance=ASSISTANCE,
            assistance_damping=ASSISTANCE_DAMPING,
            assistance_lean=ASSISTANCE_LEAN,
            assistance_roll=ASSISTANCE_ROLL,
        ),
        generations=100,  # section 5
    )


def _unassisted(study: str) -> Experiment:
    """Returns the phase in which that population goes on without, to 20 m again."""
    return dataclasses.replace(REIL_UNASSISTED, name=f"{study}/unassisted", start="population")


def _steady(study: str) -> Experiment:
    """Returns the phase in which it learns to walk from other starts, and at half the step."""
    return dataclasses.replace(
        REIL_UNASSISTED,
        name=f"{study}/steady",
        env=Reil(terrain=VARIATION),
        # ours: substitutions that find a walk are too coarse to steady it
        strategy=StrategyChoice(name="cma-es", options={"sigma": 0.04}),
        population_size=64,  # ours
        generations=200,  # ours
        terrains_per_evaluation=TRIALS,
        goal=Goal(trials=20, distance=MILESTONE, fine_trials=10, fine_factor=2),  # ours
        start="winner",
    )


def _feedback(study: str) -> Experiment:
    """Returns the phase in which the winner's network gets senses."""
    return dataclasses.replace(
        _steady(study),
        name=f"{study}/feedback",
        controller=CtrnnWalker(sense=SENSE),
        strategy=StrategyChoice(
            name="self-adaptive-ga",
            options={"sigma": 0.05, "initial_sigma": 0.05},  # ours
        ),
        start="winner",
    )


REIL = Study.of("reil", _assisted("reil"), _unassisted("reil"), _steady("reil"))
REIL_FEEDBACK = Study.of(
    "reil-feedback",
    _assisted("reil-feedback"),
    _unassisted("reil-feedback"),
    _feedback("reil-feedback"),
)
