"""Tests of pushes: what trials draw, and what a body has of a push, by C MuJoCo."""

import dataclasses
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import Action, Flame, HipTargets, LeggedEnv, MjcfEnv, Planar7, Push, Reil
from mjxwalk.envs._mujoco import mujoco

TOY = (Path(__file__).parents[1] / "toys" / "toy_biped.xml").read_text(encoding="utf-8")
LENIENT: dict[str, Any] = {"max_flight_time": 9.0, "max_time": 9.0}
DRAWN = Push(speed=0.4, spread=0.1, number=3, begin=1.0, every=2.0, duration=0.2)
SOON = Push(speed=0.5, number=2, begin=0.003, every=0.02, duration=0.0123)


def drawn(push: Push, num: int = 500) -> Any:
    """Returns the pushes of many trials."""
    pushes = push.sample(jax.random.key(0), num)
    assert pushes is not None
    return np.asarray(pushes)


def test_a_push_begins_and_ends_in_its_period() -> None:
    begin = drawn(DRAWN)[..., 0]
    assert begin.shape == (500, 3)
    first, last = np.array([1.0, 3.0, 5.0]), np.array([2.8, 4.8, 6.8])
    assert (begin >= first - 1e-6).all() and (begin <= last + 1e-6).all()
    np.testing.assert_allclose(begin.min(axis=0), first, atol=0.05)
    np.testing.assert_allclose(begin.max(axis=0), last, atol=0.05)


def test_a_period_as_long_as_the_push_says_when_it_begins() -> None:
    begin = drawn(dataclasses.replace(DRAWN, every=0.2))[..., 0]
    np.testing.assert_allclose(begin, np.broadcast_to([1.0, 1.2, 1.4], (500, 3)), rtol=1e-6)


def test_directions_are_all_ahead_or_to_either_side() -> None:
    changes = drawn(DRAWN)[..., 1:]
    speeds = np.linalg.norm(changes, axis=-1)
    assert 0.299 < speeds.min() < 0.31 and 0.49 < speeds.max() < 0.501
    assert abs(changes.mean(axis=(0, 1))).max() < 0.03  # of 0.4 m/s; they point everywhere
    ahead = drawn(dataclasses.replace(DRAWN, direction="forward"))[..., 1:]
    assert (ahead[..., 0] > 0.29).all() and not ahead[..., 1].any()
    aside = drawn(dataclasses.replace(DRAWN, direction="sideways"))[..., 1:]
    assert not aside[..., 0].any() and 0.4 < (aside[..., 1] > 0).mean() < 0.6
    behind = drawn(Push(speed=-0.4, direction="forward"))[..., 1]
    np.testing.assert_allclose(behind, -0.4, rtol=1e-6)


def test_the_same_key_draws_the_same_pushes_and_changes_no_ground() -> None:
    env, key = Planar7(push=DRAWN), jax.random.key(7)
    one, again = (env.sample_trials(key, 4) for _ in range(2))
    np.testing.assert_array_equal(one.push, again.push)
    assert (np.asarray(one.push) != env.sample_trials(jax.random.key(8), 4).push).any()
    without = Planar7().sample_trials(key, 4)
    np.testing.assert_array_equal(without.heights, one.heights)
    assert without.push is None and env.level_trials().push is None


@pytest.mark.parametrize("timestep", [0.001, 0.0007, 0.03, 0.5])
def test_a_push_gives_the_same_whatever_the_step(timestep: float) -> None:
    pushes = jnp.array([[1.0004, 0.3, -0.2], [1.5, -0.1, 0.0]], jnp.float32)
    steps = jnp.arange(round(3.0 / timestep))
    each = jax.vmap(lambda step: DRAWN.acceleration(pushes, step, timestep))(steps)
    total = timestep * np.asarray(each, np.float64).sum(axis=0)
    np.testing.assert_allclose(total, [0.2, -0.2], rtol=1e-5)
    assert not np.asarray(each)[: int(1.0 / timestep)].any()


BODIES: dict[str, LeggedEnv] = {
    "planar": Planar7(push=SOON, **LENIENT),
    "spatial": Flame(push=SOON, **LENIENT),
    "hip-powered": Reil(push=SOON, **LENIENT),
    "of a file": MjcfEnv(body=TOY, push=SOON, **LENIENT),
}


def flown(env: LeggedEnv, given: Any, num: int) -> Any:
    """Returns a body after so many steps in the air, which began at rest; numpy, float64."""
    root, motors = env.anatomy.root, len(env.anatomy.motors)
    state = jax.device_get(jax.jit(env.reset)(given))
    qpos = state.qpos.copy()
    qpos[root.height] += 5.0
    for turn in (root.yaw, root.pitch, root.roll):
        if turn is not None:
            qpos[turn] += 0.4
    state = state._replace(qpos=qpos, qvel=np.zeros_like(state.qvel))
    none: Any = np.zeros(motors)
    target: Any = state.qpos[env.anatomy.driven]
    action = HipTargets(target) if isinstance(env, Reil) else Action(none, none, none, none)
    with jax.enable_x64(True):
        state, given = (jax.tree.map(_double, each) for each in (state, given))
        action = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float64), action)

        @jax.jit
        def run(state: Any, given: Any) -> Any:
            return jax.lax.fori_loop(0, num, lambda _, now: env.step(now, action, given), state)

        return jax.device_get(run(state, given))


def _double(leaf: Any) -> Any:
    leaf = np.asarray(leaf)
    return leaf.astype(np.float64) if leaf.dtype == np.float32 else leaf


def momentum(env: LeggedEnv, state: Any) -> Any:
    """Returns the whole body's linear momentum by C MuJoCo, kg m/s."""
    model = env.model.mujoco
    data = mujoco.MjData(model)
    joints = list(env.anatomy.joint_coordinate)
    data.qpos[:], data.qvel[:] = state.qpos[joints], state.qvel[joints]
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    mujoco.mj_subtreeVel(model, data)
    return data.subtree_linvel[0] * model.body_subtreemass[0]


@pytest.mark.parametrize("name", BODIES)
def test_in_the_air_a_push_gives_its_impulse(name: str) -> None:
    env = dataclasses.replace(BODIES[name], timestep=0.0001)
    given = env.sample_trials(jax.random.key(2), 1).given(np.int32(0))
    assert given.push is not None
    state = flown(env, given, 500)  # 0.05 s; both pushes are over by then
    found = momentum(env, state)[:2]
    impulse = env.mass * np.asarray(given.push, np.float64)[:, 1:].sum(axis=0)
    if env.anatomy.root.is_planar:
        impulse[1] = 0.0
    # A step's momentum is that before its limbs have moved on.
    np.testing.assert_allclose(found, impulse, atol=2e-3 * 0.5 * env.mass)
    calm = flown(env, given._replace(push=None), 500)
    assert abs(momentum(env, calm)[:2]).max() < 2e-3 * 0.5 * env.mass


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({"speed": float("nan")}, "speed must be from"),
        ({"spread": -0.1}, "spread must be 0 or above, got -0.1"),
        ({"duration": 0.0}, "duration must be a number above 0, got 0.0"),
        ({"number": 0}, "number must be from 1"),
        ({"number": 101}, "number of pushes must be at most 100, got 101"),
        ({"every": 0.05}, "every must be the duration of a push at least, 0.1 s, got 0.05 s"),
    ],
)
def test_wrong_settings_are_refused(settings: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        Push(**settings)


def test_a_body_in_a_plane_cannot_be_pushed_sideways() -> None:
    with pytest.raises(ValueError, match='must be "forward" or "any", as .* moves in a plane'):
        Planar7(push=Push(speed=0.1, direction="sideways"))
    assert not Planar7(push=Push(direction="sideways")).push


def test_pushes_of_another_number_are_refused() -> None:
    env = Planar7(push=DRAWN)
    given = env.sample_trials(jax.random.key(0), 1).given(np.int32(0))
    assert given.push is not None
    with pytest.raises(ValueError, match=r"push must have shape \(3, 3\), got \(2, 3\)"):
        env.reset(given._replace(push=given.push[:2]))


def test_words_say_what_there_is() -> None:
    assert not Push() and Push().words() == ""
    assert DRAWN.words() == "3 of 0.3 to 0.5 m/s in any direction"
