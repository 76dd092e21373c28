"""Tests of the soft contact law."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import ContactForce, SoftContact

LAW = SoftContact(stiffness=1000.0, damping=10.0, friction=0.5)


def force(depth: float, velocity: tuple[float, float] = (0.0, 0.0), **options: Any) -> ContactForce:
    stretch = jnp.asarray(options.pop("stretch", 0.0))
    law = options.pop("law", LAW)
    settings = {"timestep": 0.001, "implicit": False} | options
    along, up = (jnp.asarray(speed) for speed in velocity)
    return law.force(jnp.asarray(depth), (along, up), stretch, **settings)


def test_spring_and_damper_add_up_and_never_pull() -> None:
    np.testing.assert_allclose(force(0.02, (0.0, -0.3)).normal, 1000 * 0.02 + 10 * 0.3, rtol=1e-6)
    leaving = force(0.001, (0.0, 5.0))
    assert leaving.normal == 0.0 and leaving.tangential == 0.0 and leaving.touching
    above = force(-0.001, (1.0, -1.0), stretch=0.01)
    assert above.normal == 0.0 and above.stretch == 0.0 and not above.touching


def test_friction_holds_up_to_its_limit_and_then_slips() -> None:
    held = force(0.02, (0.1, 0.0), stretch=0.002)
    # 2.1 mm stretch after this step at 0.1 m/s, and a limit of 0.5 x 20 N.
    np.testing.assert_allclose(held.tangential, -(1000 * 0.0021 + 10 * 0.1), rtol=1e-5)
    np.testing.assert_allclose(held.stretch, 0.0021, rtol=1e-5)
    slipping = force(0.02, (3.0, 0.0), stretch=0.05)
    np.testing.assert_allclose(slipping.tangential, -10.0, rtol=1e-6)
    np.testing.assert_allclose(slipping.stretch, 0.01, rtol=1e-6)  # 10 N / 1000 N/m


def cone(velocity: tuple[float, float], stretch: tuple[float, float]) -> ContactForce:
    sliding = (jnp.asarray(velocity), jnp.asarray(0.0))
    return LAW.force(
        jnp.asarray(0.02), sliding, jnp.asarray(stretch), timestep=0.001, implicit=False
    )


def test_in_space_friction_is_a_cone_that_pulls_against_the_slip() -> None:
    held = cone((0.1, -0.2), (0.002, 0.0))
    wanted = [-(1000 * 0.0021 + 10 * 0.1), 1000 * 0.0002 + 10 * 0.2]
    np.testing.assert_allclose(held.tangential, wanted, rtol=1e-5)
    np.testing.assert_allclose(held.stretch, [0.0021, -0.0002], rtol=1e-5)
    slipping = cone((3.0, 4.0), (0.03, 0.04))
    # Slip and stretch both point along (3, 4); the limit is 0.5 x 20 N, or 10 mm of the spring.
    np.testing.assert_allclose(slipping.tangential, [-6.0, -8.0], rtol=1e-6)
    np.testing.assert_allclose(slipping.stretch, [0.006, 0.008], rtol=1e-6)


def test_along_an_axis_the_cone_is_the_planar_law() -> None:
    for speed, stretch in ((0.1, 0.002), (3.0, 0.05), (-3.0, 0.0), (0.0, 0.0)):
        plane, space = force(0.02, (speed, 0.0), stretch=stretch), cone((speed, 0), (stretch, 0))
        np.testing.assert_allclose(space.tangential, [float(plane.tangential), 0.0], rtol=1e-6)
        np.testing.assert_allclose(space.stretch, [float(plane.stretch), 0.0], rtol=1e-6)


def test_a_foot_at_rest_does_not_creep_under_a_sideways_force() -> None:
    mass, push, dt = 2.0, 5.0, 0.001
    position = speed = stretch = 0.0
    for _ in range(5000):
        ground = force(0.02, (speed, 0.0), stretch=stretch)
        speed += dt * (push + float(ground.tangential)) / mass
        position += dt * speed
        stretch = float(ground.stretch)
    np.testing.assert_allclose(position, push / 1000.0, rtol=1e-3)  # the spring's elongation alone
    assert abs(speed) < 1e-6


def test_implicit_law_is_backward_euler_of_a_dropped_mass() -> None:
    mass, depth, speed, dt = 0.5, 0.01, -2.0, 0.001
    contact = force(depth, (0.0, speed), timestep=dt, implicit=True)
    acceleration = float(contact.normal) / (mass + float(contact.added_mass))
    # m (v' - v) / dt = k (depth - dt v') - d v', solved for v' by hand.
    wanted = (mass * speed / dt + 1000 * depth) / (mass / dt + 1000 * dt + 10)
    np.testing.assert_allclose(speed + dt * acceleration, wanted, rtol=1e-5)


def test_stiff_damping_is_stable_at_1_ms_only_when_implicit() -> None:
    law = SoftContact()  # 2,500 N s/m on a foot of 1 kg: unstable above 0.8 ms when explicit

    def speed_after(implicit: bool) -> float:
        depth, speed = 0.0002, 0.01
        for _ in range(60):
            contact = force(depth, (speed, 0.0), law=law, implicit=implicit)
            speed += 0.001 * float(contact.tangential) / (1.015 + float(contact.added_mass))
        return abs(speed)

    assert speed_after(implicit=True) < 0.001
    assert speed_after(implicit=False) > 0.005


@pytest.mark.parametrize("field", ["stiffness", "damping", "friction"])
def test_negative_settings_are_refused(field: str) -> None:
    with pytest.raises(ValueError, match=field):
        SoftContact(**{field: -1.0})
