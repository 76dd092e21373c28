"""Tests of the spatial body: against C MuJoCo, conservation laws and symmetry."""

import dataclasses
import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from c_mujoco_flame import LEFT, TIE, Reference, mujoco
from trial_states import counted

from mjxwalk.envs import Action, Flame, SerpentineWalk, State, Terrain, Trial
from mjxwalk.envs.bodies.flame_body import LEG_LENGTH, MODEL_PATH
from mjxwalk.envs.trees import GRAVITY

LEVEL = SerpentineWalk(roughness=0.0, length=10.0, width=2.0)
IMPLICIT = Flame(
    terrain=LEVEL, min_hip_height=0.01, max_flight_time=9.0, max_pitch=1.5, max_roll=3.0
)
EXPLICIT = dataclasses.replace(IMPLICIT, integrator="explicit", timestep=0.00002)
LIMP = dataclasses.replace(EXPLICIT, ankle_roll_stiffness=0.0, ankle_roll_damping=0.0)
FLAT = Trial(Terrain(jnp.zeros((1, 100, 20)), jnp.zeros((), jnp.int32)))
KEY = np.random.default_rng(5)
IN_THE_AIR = np.array(
    [0.3, -0.2, 3.0, 0.4, 0.2, -0.3, 0.08, 0.4, 0.5, -0.2, 0.1, -0.3, 0.7, 0.1, -0.2]
)
TUMBLING = KEY.normal(size=15)
STANDING = np.array([0.0] * 2 + [LEG_LENGTH - 0.001] + [0.0] * 12)
GAINS = np.array([200.0, 100.0, 100.0, 60.0, 100.0, 100.0, 60.0])


@functools.cache
def compiled(env: Flame) -> Any:
    def run(state: State, actions: Action, num: Any) -> State:
        def step(i: Any, state: State) -> State:
            return env.step(state, jax.tree.map(lambda part: part[i], actions), FLAT)

        return jax.lax.fori_loop(0, num, step, state)

    return jax.jit(run)


def run(env: Flame, state: State, actions: Action) -> State:
    """Steps a walker under one action after the other; compiles once for all numbers of them."""
    num = len(actions.torque)
    padded = jax.tree.map(lambda part: jnp.pad(part, ((0, 7500 - num), (0, 0))), actions)
    return compiled(env)(state, padded, num)


def actions(num: int, *, torque: Any = 0.0, gains: Any = 0.0) -> Action:
    """Returns actions that push, or hold the upright posture, or both."""
    gain = jnp.broadcast_to(jnp.asarray(gains, jnp.float32), (num, 7))
    push = jnp.broadcast_to(jnp.asarray(torque, jnp.float32), (num, 7))
    return Action(push, jnp.zeros((num, 7)), gain, 0.05 * gain)


def walker(env: Flame, qpos: Any = None, qvel: Any = None) -> State:
    state = env.reset(FLAT)
    if qpos is not None:
        state = state._replace(qpos=jnp.asarray(qpos, jnp.float32), qvel=jnp.zeros(15))
    if qvel is not None:
        state = state._replace(qvel=jnp.asarray(qvel, jnp.float32))
    return state


def shaking(env: Flame, num: int) -> Any:
    """Drives all motors at once: feet land, slip, twist and lift."""
    time = env.timestep * np.arange(num)[:, None]
    return np.array([3.0, 6.0, 3.0, 1.0, -5.0, 2.0, -2.0]) * np.sin(20.0 * time + np.arange(7))


CASES = {
    "falling": (IN_THE_AIR, TUMBLING, False, 0.0),
    "standing": (STANDING, None, False, GAINS),
    "stepping": (None, None, True, 0.2 * GAINS),
}


@pytest.mark.parametrize("env", [IMPLICIT, EXPLICIT], ids=["implicit", "explicit"])
@pytest.mark.parametrize("case", list(CASES))
def test_motion_agrees_with_c_mujoco(env: Flame, case: str) -> None:
    qpos, qvel, shaken, gains = CASES[case]
    before = walker(env, qpos, qvel)
    num = round((0.15 if env is IMPLICIT else 0.04) / env.timestep)
    plan = actions(num, torque=shaking(env, num) if shaken else 0.0, gains=gains)
    reference = Reference(env, np.asarray(before.qpos), np.asarray(before.qvel))
    for i in range(num):
        reference.step(*(np.asarray(part[i], np.float64) for part in plan))
    state = run(env, before, plan)
    assert state.touching.any() == (case != "falling") and not state.trial.diverged
    data = reference.data
    np.testing.assert_array_equal(data.qpos[11], data.qpos[6])
    # float32 keeps heights to 6e-8 m, so a corner's spring of 12,500 N/m errs by 1e-3 N, on feet
    # that roll about 1e-4 kg m^2: their rates ring, hence ten to a hundred times the error.
    np.testing.assert_allclose(state.qpos, data.qpos[LEFT], atol=2e-4)
    np.testing.assert_allclose(state.qvel, data.qvel[LEFT], atol=2e-2)
    np.testing.assert_allclose(state.stretch, reference.stretch, atol=1e-4)
    np.testing.assert_allclose(state.trial.torque_cost, reference.torque_cost, rtol=1e-3, atol=1e-4)
    ankles = data.xpos[[data.body(f"0/foot_{leg}").id for leg in ("left", "right")]] - data.qpos[:3]
    heading = np.array([np.cos(data.qpos[3]), np.sin(data.qpos[3]), 0.0])
    # The walker's are those that the last step saw, up to 1 ms at some 3 m/s ago.
    np.testing.assert_allclose(state.ankle_x, ankles @ heading, atol=4e-3)


def test_shared_adduction_moves_as_under_an_equality_constraint_of_c_mujoco() -> None:
    spec = mujoco.MjSpec.from_file(str(MODEL_PATH))
    # Constraints of MuJoCo give way by one part in 1e4 at this impedance.
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1="adduction_left",
        name2="adduction_right",
        data=[0.0, 1.0] + [0.0] * 10,
        solimp=[0.9999, 0.9999, 0.001, 0.5, 2],
    )
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = TIE @ IN_THE_AIR, TIE @ TUMBLING
    data.qfrc_applied[[6, 7]] = 2.0, -3.0
    mujoco.mj_forward(model, data)
    torque = np.array([2.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    after = run(LIMP, walker(LIMP, IN_THE_AIR, TUMBLING), actions(1, torque=torque))
    acceleration = (np.asarray(after.qvel) - TUMBLING) / LIMP.timestep
    # float32 rates of 1 rad/s over 0.02 ms resolve accelerations to 0.006 rad/s^2.
    np.testing.assert_allclose(acceleration, data.qacc[LEFT], rtol=1e-3, atol=0.02)
    untied = np.abs(data.qacc_smooth[6] - data.qacc_smooth[11])
    assert untied > 10.0  # the tie has work to do


def test_free_flight_keeps_momentum_and_energy() -> None:
    before, num = walker(LIMP, IN_THE_AIR, TUMBLING), 5000
    after = run(LIMP, before, actions(num))
    assert not after.trial.diverged
    one, other = mechanics(LIMP, before), mechanics(LIMP, after)
    mass, time = LIMP.weight / GRAVITY, num * LIMP.timestep
    fallen = one["linear"] - np.array([0.0, 0.0, mass * GRAVITY * time])
    # Rounding adds up to 5,000 steps x 6e-8 x 20 kg m/s at the very worst.
    np.testing.assert_allclose(other["linear"], fallen, atol=6e-3)
    np.testing.assert_allclose(other["angular"], one["angular"], atol=2e-3)
    # The step's own error: 0.02 ms of some 10 J of kinetic energy turning over in 0.1 s.
    np.testing.assert_allclose(other["energy"], one["energy"], atol=5e-3)


def mechanics(env: Flame, state: State) -> dict[str, Any]:
    """Momenta about the centre of mass and energy, by C MuJoCo."""
    model = env.model.mujoco
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = TIE @ state.qpos, TIE @ state.qvel
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    return {
        "linear": data.subtree_linvel[1] * env.weight / GRAVITY,
        "angular": data.subtree_angmom[1].copy(),
        "energy": data.energy.sum(),
    }


def mirrored(values: Any) -> Any:
    """Returns coordinates or their rates with left and right exchanged."""
    swap = [0, 1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 7, 8, 9, 10]
    sign = np.ones(15)
    sign[[1, 3, 5]] = -1.0  # y, yaw, roll
    return np.asarray(values)[swap] * sign


def test_a_mirrored_state_makes_the_mirrored_motion() -> None:
    num = 150
    one = walker(IMPLICIT)
    one = one._replace(qvel=one.qvel.at[3].set(0.4))  # some yaw, too
    other = walker(IMPLICIT, mirrored(one.qpos), mirrored(one.qvel))
    torque = shaking(IMPLICIT, num)
    one = run(IMPLICIT, one, actions(num, torque=torque, gains=0.2 * GAINS))
    swapped = torque[:, [0, 4, 5, 6, 1, 2, 3]]
    other = run(IMPLICIT, other, actions(num, torque=swapped, gains=0.2 * GAINS))
    assert one.touching.any() and abs(one.qpos[3]) > 0.001
    # Sums over the legs run in another order; contact carries that rounding on as above.
    np.testing.assert_allclose(mirrored(other.qpos), one.qpos, atol=2e-4)
    np.testing.assert_allclose(np.roll(other.stretch, 4, 0) * [1, -1], one.stretch, atol=1e-4)
    np.testing.assert_allclose(other.ankle_x[::-1], one.ankle_x, atol=2e-4)


def test_implicit_steps_of_1_ms_follow_the_explicit_ones_of_a_fiftieth() -> None:
    fine = run(EXPLICIT, walker(EXPLICIT), actions(7500, gains=GAINS))
    coarse = run(IMPLICIT, walker(IMPLICIT), actions(150, gains=GAINS))
    # Either step is of first order; over 0.15 s, in which the swing leg stops and the sole comes
    # to bear, they part by a few mm and mrad.
    np.testing.assert_allclose(coarse.qpos, fine.qpos, atol=1e-2)


def test_the_ankles_roll_back_by_themselves() -> None:
    tilted = IN_THE_AIR.copy()
    tilted[[10, 14]] = 0.3, -0.2
    after = run(IMPLICIT, walker(IMPLICIT, tilted), actions(200))
    assert np.all(np.abs(np.asarray(after.qpos)[[10, 14]]) < 0.02)
    assert after.trial.torque_cost == 0.0  # springs are no motors


def test_walker_starts_on_its_right_foot_that_stands_still() -> None:
    env = Flame(terrain=LEVEL)
    state = walker(env)
    data = mujoco.MjData(env.model.mujoco)
    data.qpos[:], data.qvel[:] = TIE @ state.qpos, TIE @ state.qvel
    mujoco.mj_forward(env.model.mujoco, data)
    heights = data.site_xpos[:, 2]
    assert np.all(heights[:4] > 0.02)
    pressed = -4.0 * env.contact.stiffness * heights[4:].mean()
    np.testing.assert_allclose(pressed, env.weight, rtol=1e-3)
    np.testing.assert_allclose(np.ptp(heights[4:]), 0.0, atol=1e-3)  # level
    moving = np.zeros(6)
    foot = env.model.mujoco.body("foot_right").id
    mujoco.mj_objectVelocity(env.model.mujoco, data, mujoco.mjtObj.mjOBJ_BODY, foot, moving, 0)
    np.testing.assert_allclose(moving[3:], 0.0, atol=1e-6)
    ankles = [data.body(foot).xpos[0] for foot in ("foot_left", "foot_right")]
    np.testing.assert_allclose(state.ankle_x, ankles, atol=1e-6)
    after = run(env, state, actions(1))
    assert not after.trial.done and env.observe(after).contact.tolist() == [False, True]


def test_settings_agree_with_the_model_file() -> None:
    env = Flame()
    model = env.model.mujoco
    np.testing.assert_allclose(env.weight / GRAVITY, 10.99)  # the sum of the table of links
    leg = -model.body("shank_left").pos[2] - model.body("foot_left").pos[2]
    np.testing.assert_allclose(LEG_LENGTH, leg - model.site("heel_in_left").pos[2])
    assert model.nv == 16 and env.floating.mujoco.nv == 16
    np.testing.assert_allclose(model.body_mass, env.floating.mujoco.body_mass)


def test_every_rule_of_a_trial_ends_it() -> None:
    env = Flame(terrain=LEVEL)
    standing = walker(env, STANDING)
    assert not run(env, standing, actions(1)).trial.done
    falls = [standing._replace(qpos=standing.qpos.at[2].set(0.554))]
    for angle, limit in ((3, env.max_yaw), (4, env.max_pitch), (5, env.max_roll)):
        for sign in (-1.0, 1.0):
            falls.append(standing._replace(qpos=standing.qpos.at[angle].set(sign * limit * 1.01)))
    high = standing.qpos.at[2].add(0.2)
    falls.append(counted(standing._replace(qpos=high), flight_time=jnp.float32(0.0095)))
    for state in falls:
        after = run(env, state, actions(1)).trial
        assert after.fell and after.done and not after.diverged
    spent = counted(standing, torque_cost=jnp.float32(env.torque_budget))
    late = counted(standing, num_steps=jnp.int32(59_999))
    late = late._replace(qpos=standing.qpos.at[0].set(20.0))
    # Four seconds for 0.25 m/s to be 1 m ahead.
    stalled = counted(standing, num_steps=jnp.int32(4_400))
    for state in (spent, late, stalled):
        after = run(env, state, actions(1)).trial
        assert after.done and not after.fell


@pytest.mark.parametrize("absurd", [np.nan, np.inf, 1e30])
def test_physics_that_diverges_ends_the_walker_at_its_last_sound_state(absurd: float) -> None:
    before = walker(IMPLICIT)
    after = run(IMPLICIT, before, actions(1, torque=absurd))
    trial = after.trial
    assert trial.diverged and trial.fell and trial.done
    np.testing.assert_array_equal(after.qpos, before.qpos)
    assert np.isfinite(trial.torque_cost)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"timestep": 0.0}, "timestep must be a number above 0, got 0.0"),
        ({"ankle_roll_damping": -1.0}, "ankle_roll_damping must be 0 or above, got -1.0"),
        ({"integrator": "rk4"}, 'integrator must be "implicit" or "explicit", got "rk4"'),
        ({"max_roll": float("nan")}, "max_roll must be a number above 0, got nan"),
    ],
)
def test_wrong_settings_are_refused(
    settings: dict[str, Any], message: str, unchecked_types: None
) -> None:
    with pytest.raises(ValueError, match=message):
        Flame(**settings)
