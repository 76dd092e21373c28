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
from mjxwalk.errors import near
from mjxwalk.experiments import walk
from mjxwalk.experiments.experiment import Experiment

CLASSES: dict[str, type[Policy]] = {
    "linear": LinearFeedback,
    "mlp": Mlp,
    "recurrent": RecurrentNetwork,
    "ctrnn": PatternGenerator,
    "harmonics": Harmonics,
}
KEPT = ("period", "moved", "normalise")  # of an experiment's own policy


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
    if name not in CLASSES:
        raise ValueError(f"unknown controller {name!r}{near(name, CLASSES)}")
    own, named = experiment.controller, f"{experiment.name}+{name}"
    if isinstance(own, Policy):
        kept = {setting: getattr(own, setting) for setting in KEPT}
        return dataclasses.replace(experiment, name=named, controller=CLASSES[name](**kept))
    env = experiment.env
    if not hasattr(env, "anatomy"):
        return dataclasses.replace(experiment, name=named, controller=CLASSES[name]())
    if all(motor.law == "torque" for motor in env.anatomy.motors):
        env = dataclasses.replace(env, acting="target")
    return dataclasses.replace(
        experiment,
        name=named,
        env=env,
        controller=CLASSES[name](period=walk.period(env.walking_time)),
        # What they evolve with is for weights of linear reactive control, which are larger.
        strategy=walk.STRATEGY,
    )
