"""An experiment with a body that a user brings, its settings scaled from our body's to that.

The experiment `walk` takes any body; those of our own bodies take others of the same joints.
ours: two bodies of one shape that move alike have torques as their weights times their lengths; so
have the settings that are torques, those that are heights go by leg length, and the others stay.
"""

import dataclasses
import math
from typing import Any

from mjxwalk.envs import Flame, MjcfEnv, Planar7
from mjxwalk.envs.bodies import flame_body, planar7_body
from mjxwalk.experiments import walk
from mjxwalk.experiments.experiment import Experiment

BODIES = (Planar7, Flame)


def with_body(experiment: Any, text: str) -> Experiment:
    """Returns the experiment with another body.

    Args:
      experiment: an `Experiment` with a body of ours.
      text: MJCF of the other.

    Raises:
      ValueError: the experiment has no body that can be another, or the text is none.
    """
    env = getattr(experiment, "env", None)  # which a fit lacks
    if isinstance(env, MjcfEnv):
        return walk.with_body(experiment, text)
    if not isinstance(env, BODIES):
        kind = "no body" if env is None else f"the body {type(env).__name__}"
        raise ValueError(
            f"{experiment.name} has {kind}, which takes no other; choose {walk.NAME}, which takes "
            "any, or an experiment of Planar7 or Flame, such as planar-lpd or solomon-3d"
        )
    ours = env
    env = _planar(env, text) if isinstance(env, Planar7) else _spatial(env, text)
    taller, stronger = _ratios(ours, env)
    rules = ("min_hip_height", taller), ("torque_budget", stronger)
    env = dataclasses.replace(env, **{name: getattr(env, name) * by for name, by in rules})
    test_settings = dict(experiment.test_settings)
    for name, by in rules:
        if name in test_settings:
            test_settings[name] *= by
    return dataclasses.replace(
        experiment,
        env=env,
        test_settings=test_settings,
        controller=experiment.controller.scaled(stronger),
    )


def _ratios(ours: Any, theirs: Any) -> tuple[float, float]:
    """Returns how much longer the legs are, and how much larger torques are to be."""
    taller = theirs.leg_length / ours.leg_length
    heavier = theirs.weight / ours.weight
    # Rounded, so that our own body changes nothing.
    return round(taller, 9), round(taller * heavier, 9)


def _planar(env: Planar7, text: str) -> Planar7:
    planar7_body.check(text)
    mass, size = planar7_body.masses(text), planar7_body.sizes(text)
    toes = (size.leg - size.sole) * math.sin(abs(env.start_hip_angle)) + size.toe
    spacing = env.terrain.spacing
    node = round(spacing * math.ceil(toes / spacing), 9)  # the first beyond the toes at the start
    return dataclasses.replace(
        env,
        body=text,
        torso_mass=mass.torso,
        thigh_mass=mass.thigh,
        shank_mass=mass.shank,
        foot_mass=mass.foot,
        terrain=dataclasses.replace(env.terrain, flat_until=max(env.terrain.flat_until, node)),
    )


def _spatial(env: Flame, text: str) -> Flame:
    flame_body.check(text)
    stiffness, damping = flame_body.ankle_roll(text)
    given = {"ankle_roll_stiffness": stiffness, "ankle_roll_damping": damping}
    # A file without springs there leaves ours: the joint has no motor, and would swing free.
    return dataclasses.replace(env, body=text, **(given if stiffness or damping else {}))
