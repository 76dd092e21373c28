"""Tests of the ground's force on slopes and on other soil, against statics."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.engines import lanes
from mjxwalk.envs import (
    Action,
    Course,
    Flame,
    LeggedEnv,
    Planar7,
    RandomWalk,
    SerpentineWalk,
    Slope,
    Stretches,
)

LEVEL = {"planar": RandomWalk(roughness=0.0), "spatial": SerpentineWalk(roughness=0.0, width=0.4)}
GRADIENT = 0.1
ASTRIDE = 0.3  # rad, of the hips to either side; a body that stands straight would tip over
DEEP = 0.002  # m, of the soles in the ground


def on(body: str, friction: float, gradient: float = 0.0, **course: Any) -> LeggedEnv:
    """Returns a body whose trials no rule ends, on a slope or on ground with a course."""
    lenient: Any = {"max_flight_time": 9.0, "min_hip_height": 0.01, "max_time": 9.0}
    kind: Any = {"planar": Planar7, "spatial": Flame}[body]
    slope = Slope(gradient=gradient)
    env = kind(terrain=LEVEL[body], course=Course(slope=slope, **course), **lenient)
    return dataclasses.replace(env, contact=dataclasses.replace(env.contact, friction=friction))


def stands(env: LeggedEnv, x: float, tilt: float = 0.0) -> tuple[Any, Any]:
    """Returns a trial, and a walker astride at x, turned by a tilt with its toes up, rad."""
    given = env.sample_trials(jax.random.key(0), 1).given(jnp.int32(0))
    state, root = jax.jit(env.reset)(given), env.anatomy.root
    astride = np.zeros(len(env.anatomy.coordinates))
    for leg, hip in (("left", ASTRIDE), ("right", -ASTRIDE)):
        astride[env.anatomy.place(f"hip_{leg}")] = hip
        astride[env.anatomy.place(f"ankle_{leg}")] = -hip  # soles along the slope
    astride[root.pitch] = -tilt
    # The middle of the feet is at x, and the hips are over it, as seen along the normal.
    y = None if root.is_planar else jnp.zeros(())
    ground = float(env.ground_height(given, jnp.float32(x), y))
    soles = env.anatomy.points[0].offset[2]
    high = (env.leg_length + soles) * np.cos(ASTRIDE) - soles - DEEP
    astride[root.forward] = x - high * np.sin(tilt)
    astride[root.height] = ground + high * np.cos(tilt)
    return given, state._replace(
        qpos=jnp.asarray(astride, jnp.float32), qvel=jnp.zeros_like(state.qvel)
    )


def held(env: LeggedEnv, tilt: float) -> Any:
    """Returns a walker that holds its joints for 1 s, each 0.1 s [time, coordinate]; numpy."""
    given, state = stands(env, 6.0, tilt)
    num = len(env.anatomy.motors)
    stiff = jnp.full(num, 20_000.0)
    action = Action(jnp.zeros(num), state.qpos[env.anatomy.driven], stiff, 0.05 * stiff)

    def tenth(state: Any) -> Any:
        steps = round(0.1 / env.timestep)
        return jax.lax.fori_loop(0, steps, lambda _, now: env.step(now, action, given), state)

    walk, qpos = lanes.vmap(tenth, (0,)), []
    state = jax.tree.map(lambda leaf: np.asarray(leaf)[None], state)
    for _ in range(10):
        state = walk(state)
        qpos.append(np.asarray(state.qpos)[0])
    return np.array(qpos)


@pytest.mark.parametrize("gradient", [GRADIENT, -GRADIENT], ids=["uphill", "downhill"])
def test_a_walker_slips_above_the_friction_angle_only(gradient: float) -> None:
    tilt = float(np.arctan(gradient))
    stays, slips = (
        # Points that slip drag the masses of the implicit step, which go with its length.
        held(dataclasses.replace(on("planar", share * GRADIENT, gradient), timestep=0.0002), tilt)
        for share in (1.3, 0.7)
    )
    assert np.abs(stays[3:, 0] - stays[-1, 0]).max() < 0.002  # from 0.4 s on, when it has settled
    assert np.abs(slips[:, 2] + tilt).max() < 0.01  # and does not tip over
    acceleration = np.diff(slips[3:, 0], n=2) / 0.1**2
    down = 9.81 * (np.sin(tilt) - np.sign(tilt) * 0.7 * GRADIENT * np.cos(tilt))
    np.testing.assert_allclose(acceleration, -down * np.cos(tilt), rtol=0.05)


@pytest.mark.slow
def test_in_space_it_does_so_too() -> None:
    tilt = float(np.arctan(-GRADIENT))
    stays, slips = (held(on("spatial", share * GRADIENT, -GRADIENT), tilt) for share in (2.0, 0.5))
    assert abs(stays[-1, 0] - stays[3, 0]) < 0.005
    assert slips[-1, 0] - slips[3, 0] > 0.1


@pytest.mark.parametrize("body", ["planar", "spatial"])
def test_slippery_ground_halves_the_force_that_brakes(body: str) -> None:
    forces: list[Any] = []
    for factor in (1.0, 0.5):
        env = on(body, 0.8, slippery=Stretches(factor=factor, spread=0.0))
        given, state = stands(env, 3.5)
        sliding = state._replace(qvel=state.qvel.at[0].set(2.0))
        forces.append(np.asarray(jax.jit(env.ground_forces)(sliding, given)).sum(axis=0))
    usual, slippery = forces
    assert usual[2] > 0.0 and usual[0] == pytest.approx(-0.8 * usual[2], rel=1e-5)
    np.testing.assert_allclose(slippery, usual * [0.5, 0.5, 1.0], rtol=1e-5, atol=1e-6)


def test_soft_ground_gives_way_twice_as_far() -> None:
    forces: list[Any] = []
    for factor in (1.0, 0.5):
        env = on("planar", 1.0, soft=Stretches(factor=factor, spread=0.0))
        given, state = stands(env, 3.5)
        moving = state._replace(qvel=state.qvel.at[1].set(-0.1))
        forces.append(np.asarray(jax.jit(env.ground_forces)(moving, given)))
    # Spring and damper alike, so that the friction that they allow halves too.
    np.testing.assert_allclose(forces[1], 0.5 * forces[0], rtol=1e-6)
    assert (forces[0][:, 2] > 0.0).all()


def test_on_a_slope_the_ground_pushes_along_its_normal() -> None:
    env = on("planar", 0.0, GRADIENT)
    given, state = stands(env, 6.0, float(np.arctan(GRADIENT)))
    force = np.asarray(jax.jit(env.ground_forces)(state, given)).sum(axis=0)
    assert force[2] > 0.0 and force[0] == pytest.approx(-GRADIENT * force[2], rel=1e-4)
