"""The experiment of any body: what is derived from size and weight, and bodies that change."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

from mjxwalk import experiments, robots
from mjxwalk.envs import MjcfEnv
from mjxwalk.envs.mjcf import reader
from mjxwalk.experiments import own_body, walk

TWO_DIGITS = 0.06  # settings are rounded so, either by 5 % at most where they begin with 1
TOY = (Path(__file__).parents[1] / "toys" / "toy_biped.xml").read_text(encoding="utf-8")


def twice_as_long(text: str) -> str:
    """Returns the toy with all lengths doubled and eight times the mass: the same shape."""

    def doubled(match: re.Match[str]) -> str:
        numbers = " ".join(f"{2 * float(number):.9g}" for number in match[2].split())
        return f'{match[1]}="{numbers}"'

    text = re.sub(r'\b(pos|size|fromto)="([^"]*)"', doubled, text)
    return re.sub(r'\bmass="([^"]*)"', lambda match: f'mass="{8 * float(match[1]):.9g}"', text)


def test_a_body_of_twice_the_size_has_the_same_task() -> None:
    """By Froude's law speeds go by the root of length, and stiffness by force over length."""
    small, large = MjcfEnv.of(TOY), MjcfEnv.of(twice_as_long(TOY))
    assert large.leg_length == pytest.approx(2 * small.leg_length, rel=1e-6)
    assert large.weight == pytest.approx(8 * small.weight, rel=1e-6)
    assert large.terms.speed == pytest.approx(np.sqrt(2) * small.terms.speed, rel=TWO_DIGITS)
    assert large.contact.stiffness == pytest.approx(4 * small.contact.stiffness, rel=TWO_DIGITS)
    assert large.joint_stop.stiffness == pytest.approx(
        16 * small.joint_stop.stiffness, rel=TWO_DIGITS
    )
    gains = [np.array([motor.stiffness for motor in env.anatomy.motors]) for env in (small, large)]
    # The toy's motors are limited to 40 N m, and hold no stiffer than that allows.
    assert gains[0] == pytest.approx(min(40.0 / 0.05, 1.5 * small.weight * small.leg_length))
    assert gains[1] == pytest.approx(40.0 / 0.05)


def test_another_body_brings_its_own_settings_and_keeps_the_rest() -> None:
    usual = dataclasses.replace(experiments.get("walk"), generations=7)
    changed = own_body.with_body(usual, reader.read(robots.path("walker2d")).text)
    assert changed.generations == 7 and changed.env.anatomy.root.is_planar
    assert changed.env.terms.speed != usual.env.terms.speed
    motors = [motor.name for motor in changed.env.anatomy.motors]
    assert list(changed.controller.layout.outputs) == motors
    # From the command to the goal: a walker at the wanted speed covers the distance in its time.
    assert changed.env.terms.speed * changed.env.max_time > changed.goal.distance


def test_bodies_of_one_contact_law_take_no_other() -> None:
    with pytest.raises(ValueError, match="planar-lpd has one contact law"):
        walk.with_contact(experiments.get("planar-lpd"), "mujoco")


def test_a_walker_without_ankles_moves_its_trunk() -> None:
    humanoid = walk.of_body(reader.read(robots.path("humanoid")).text)
    assert humanoid.controller.moved == "all"
    assert any("waist" in name for name in humanoid.controller.layout.outputs)
    assert experiments.get("walk").controller.moved == "legs"
