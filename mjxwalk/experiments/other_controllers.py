"""Experiments in which something else decides than in those that they are named after."""

import dataclasses
from typing import Any

from mjxwalk.controllers import (
    Harmonics,
    LinearFeedback,
    Mlp,
    PatternGenerator,
    Policy,
    RecurrentNetwork,
)
from mjxwalk.experiments.experiment import Experiment

CLASSES: dict[str, type[Policy]] = {
    "linear": LinearFeedback,
    "mlp": Mlp,
    "recurrent": RecurrentNetwork,
    "ctrnn": PatternGenerator,
    "harmonics": Harmonics,
}
KEPT = ("period", "moved", "normalise")  # of an experiment's own policy
PERIOD = 0.005  # s; ours: of motors that give torques, which nothing holds in between


def with_controller(experiment: Any, name: str) -> Experiment:
    """Returns an experiment in which a controller of that name decides.

    Raises:
      ValueError: nothing decides in it that could be another, or it goes on with a population or
        a walker of its own controller.
    """
    if not isinstance(experiment, Experiment):
        raise ValueError(f"{experiment.name} has no controller that could be another")
    if experiment.start != "zero" or experiment.pruning is not None:
        raise ValueError(
            f"{experiment.name} goes on with what evolved before; choose a controller for an "
            "experiment that starts from zero, such as planar-fil"
        )
    own = experiment.controller
    if isinstance(own, Policy):
        given: dict[str, Any] = {setting: getattr(own, setting) for setting in KEPT}
    else:  # nothing damps motors that give torques, so a policy has to feel rates
        given = {"rates": True, "period": PERIOD}
    return dataclasses.replace(
        experiment, name=f"{experiment.name}+{name}", controller=CLASSES[name](**given)
    )
