"""Tests of walkers in C MuJoCo: every body moves as its environment has it, and slips show."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from verify.stepped import (
    BODIES,
    BURDENED,
    BUSY,
    ON_COURSE,
    ROBOTS,
    actions,
    by_engine,
    by_reference,
    field,
    placed,
    with_field,
)

from mjxwalk.envs import LeggedEnv, Reil
from mjxwalk.verify import laws

NUM = 150  # steps; feet land, slip and lift in them
CLOSE = 1e-6  # m or rad


EVERY = BODIES | ON_COURSE | BURDENED


@pytest.mark.parametrize("name", EVERY)
def test_a_body_moves_as_by_its_environment(name: str) -> None:
    check_alike(EVERY[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_a_body_that_ships_moves_as_by_its_environment(name: str) -> None:
    check_alike(ROBOTS[name])


def check_alike(env: LeggedEnv) -> None:
    expected, found = by_engine(env, NUM), by_reference(env, NUM)
    assert expected.touching.any() and not expected.trial.diverged.any()
    # Constants of float32 are right to 6e-8; contact carries that on, rates of light feet ring.
    np.testing.assert_allclose(found.qpos, expected.qpos, atol=CLOSE)
    np.testing.assert_allclose(found.qvel, expected.qvel, atol=100 * CLOSE)
    np.testing.assert_allclose(
        found.stretch, expected.stretch.reshape(found.stretch.shape), atol=CLOSE
    )


def apart(name: str, env: LeggedEnv) -> float:
    """Returns how far apart the coordinates are if C MuJoCo has other settings, m or rad."""
    found = by_reference(env, NUM, at=EVERY[name])
    return float(np.abs(by_engine(EVERY[name], NUM).qpos - found.qpos).max())


SLIPS = {
    "planar": ["torso_mass", "contact.stiffness", "contact.damping", "joint_stop.stiffness"],
    "spatial": ["ankle_roll_stiffness", "ankle_roll_damping", "contact.friction"],
    "hip-powered": [
        "ankle_damping",
        "ankle_rest",
        "ankle_stiffness",
        "assistance",
        "assistance_damping",
        "assistance_lean",
        "assistance_roll",
        "contact.damping",
        "contact.stiffness",
        "hip_roll_damping",
        "hip_roll_stiffness",
        "hips.approach",
        "hips.max_speed",
        "hips.max_torque",
        "hips.softness",
        "knee_cap.damping",
        "knee_cap.stiffness",
        "knee_damping",
        "sole",
        "terrain.load",
        "toe",
    ],
}


@pytest.mark.parametrize("place", [(name, path) for name, paths in SLIPS.items() for path in paths])
def test_a_setting_that_differs_by_a_hundredth_shows(place: tuple[str, str]) -> None:
    name, path = place
    env = BODIES[name]
    assert apart(name, with_field(env, path, 1.01 * field(env, path))) > 2.0 * CLOSE


@pytest.mark.parametrize(
    "path", ["push.duration", "payload.share", "payload.forward", "payload.up"]
)
@pytest.mark.parametrize("name", BURDENED)
def test_a_slip_in_a_push_or_payload_shows(name: str, path: str) -> None:
    env = BURDENED[name]
    assert apart(name, with_field(env, path, 1.01 * field(env, path))) > 2.0 * CLOSE


@pytest.mark.parametrize("part", ["height", "gradient", "stiffness", "friction"])
@pytest.mark.parametrize("name", ON_COURSE)
def test_a_slip_in_the_course_shows(name: str, part: str, monkeypatch: pytest.MonkeyPatch) -> None:
    right = laws.lying

    def wrong(*args: Any) -> Any:
        found = right(*args)
        return found._replace(**{part: 1.01 * getattr(found, part)})

    monkeypatch.setattr(laws, "lying", wrong)
    assert apart(name, ON_COURSE[name]) > 2.0 * CLOSE


def test_a_slip_in_a_law_of_ours_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    right = laws.ground_force

    def wrong(*args: Any, **settings: Any) -> Any:
        push = right(*args, **settings)
        return push._replace(mass=0.99 * push.mass)

    monkeypatch.setattr(laws, "ground_force", wrong)
    assert apart("planar", BODIES["planar"]) > 2.0 * CLOSE


@dataclasses.dataclass(frozen=True, kw_only=True)
class WithBall(Reil):
    """The body with a small, heavy ball fixed to the trunk's centre."""

    ball: float

    def spec(self) -> Any:
        """Returns the body with the ball."""
        spec = super().spec()
        ball = spec.body("torso").add_body(pos=[0.0, 0.0, self.trunk_height])
        ball.mass, ball.inertia, ball.explicitinertial = self.ball, [1e-9] * 3, True
        ball.ipos = [0.0] * 3
        return spec


@pytest.mark.parametrize("integrator", ["implicit", "explicit"])
def test_a_load_moves_as_a_ball_of_that_mass(integrator: Any) -> None:
    timestep = 0.002 if integrator == "implicit" else 0.00002
    env = dataclasses.replace(BUSY, integrator=integrator, timestep=timestep)
    loaded = by_reference(env, 20)
    load: Any = loaded.load
    settings = {each.name: getattr(env, each.name) for each in dataclasses.fields(env)}
    settings["terrain"] = dataclasses.replace(env.terrain, load=0.0)
    for row in np.flatnonzero(load > 0):
        ball = WithBall(**settings, ball=float(8.0 * load[row]))
        found = by_reference(ball, 20, at=env)
        np.testing.assert_allclose(found.qpos[row], loaded.qpos[row], atol=1e-9)
        assert np.abs(found.qpos[1 - row] - loaded.qpos[1 - row]).max() > 1e-6
    assert (load > 0).any()


def test_walkers_at_rest_stay_where_they_are() -> None:
    env = BODIES["planar"]
    reference, (action, *_) = placed(env), actions(env, 1)
    before = reference.qpos.copy()
    given = [np.repeat(np.float64(action), 2, axis=0)] * 4
    reference.step(given, np.array([True, False]))
    assert (reference.qpos[0] != before[0]).any() and (reference.qpos[1] == before[1]).all()
