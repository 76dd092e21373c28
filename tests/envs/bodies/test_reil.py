"""Tests of the hip-powered biped: against C MuJoCo, conservation laws and symmetry."""

import dataclasses
import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from c_mujoco_reil import Reference, mujoco
from trial_states import counted

from mjxwalk.engines import lanes
from mjxwalk.envs import (
    TRIAL_AXES,
    HipTargets,
    Reil,
    State,
    Trial,
    TrialVariation,
    VelocityMotor,
)
from mjxwalk.envs.bodies.reil_body import LEG
from mjxwalk.envs.bodies.reil_trials import usual
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.trees import GRAVITY

IMPLICIT = Reil(
    timestep=0.001,
    knee_extension=0.0,
    knee_damping=5.0,
    ankle_stiffness=1550.0,
    ankle_damping=42.0,
    ankle_rest=0.1,
    heel=-0.1,
    min_speed=0.25,
    toe=0.18,
    knee_cap=JointStop(stiffness=5000.0, damping=60.0),
    terrain=TrialVariation(load=8.0, stride=0.1, push=0.2, sideways=0.1, pitch_rate=0.3),
    min_height=0.01,
    max_flight_time=9.0,
    max_still_time=9.0,
    assistance=200.0,
    assistance_damping=30.0,
    assistance_lean=0.1,
    assistance_roll=0.5,
    hips=VelocityMotor(approach=25.0, max_speed=5.0, max_torque=300.0, softness=1e-4),
)
EXPLICIT = dataclasses.replace(
    IMPLICIT,
    integrator="explicit",
    timestep=0.00005,
    hip_roll_damping=300.0,  # more would need smaller steps
)
LIMP = dataclasses.replace(
    EXPLICIT,
    hip_roll_stiffness=0.0,
    hip_roll_damping=0.0,
    knee_damping=0.0,
    ankle_stiffness=0.0,
    ankle_damping=0.0,
    assistance=0.0,
    assistance_damping=0.0,
    hips=VelocityMotor(approach=1.0, max_speed=1.0, max_torque=1e-6),
)
FIRST = jnp.zeros((), jnp.int32)
FLAT = usual().given(FIRST)
RANDOM = np.random.default_rng(5)
IN_THE_AIR = np.array([0.3, -0.2, 3.0, 0.4, 0.2, -0.3, 0.1, 0.4, 0.5, -0.2, 0.05, -0.3, 0.7, 0.1])
TUMBLING = RANDOM.normal(size=14)
STANDING = np.array([0.0] * 2 + [LEG + 0.12 - 0.003] + [0.0] * 11)


@functools.cache
def compiled(env: Reil) -> Any:
    def run(state: State, targets: Any, trial: Trial, num: Any) -> State:
        def step(at: tuple[Any, State]) -> tuple[Any, State]:
            return at[0] + 1, env.step(at[1], HipTargets(targets[at[0]]), trial)

        return jax.lax.while_loop(lambda at: at[0] < num, step, (jnp.zeros((), int), state))[1]

    return lanes.vmap(run, (0, None, TRIAL_AXES, None))


def run(env: Reil, state: State, targets: Any, trial: Trial = FLAT) -> State:
    """Steps a walker towards one pair of targets after the other; compiles once for all numbers."""
    num = len(targets)
    padded = np.pad(np.asarray(targets, np.float32), ((0, 2000 - num), (0, 0)))
    alone = state, trial._replace(ground=trial.ground.row)
    state, drawn = jax.tree.map(lambda leaf: np.asarray(leaf)[None], alone)
    drawn = drawn._replace(ground=trial.ground._replace(row=drawn.ground))
    after = compiled(env)(state, padded, drawn, np.int32(num))
    return jax.tree.map(lambda leaf: jnp.asarray(leaf[0]), after)


def walker(env: Reil, qpos: Any = None, qvel: Any = None) -> State:
    state = env.reset(FLAT)
    if qpos is not None:
        state = state._replace(qpos=jnp.asarray(qpos, jnp.float32), qvel=jnp.zeros(14))
    if qvel is not None:
        state = state._replace(qvel=jnp.asarray(qvel, jnp.float32))
    return state


def swinging(env: Reil, num: int) -> Any:
    """Targets that the hips follow at their limits: feet land, slip and lift."""
    time = env.timestep * np.arange(num)
    return np.stack([0.5 * np.sin(20.0 * time), -0.3 * np.sin(15.0 * time)], axis=1)


CASES = {
    "falling": (IN_THE_AIR, TUMBLING, True),
    "standing": (STANDING, None, False),
    "stepping": (None, 0.2 * TUMBLING, True),
}


@pytest.mark.parametrize("env", [IMPLICIT, EXPLICIT], ids=["implicit", "explicit"])
@pytest.mark.parametrize("case", list(CASES))
def test_motion_agrees_with_c_mujoco(env: Reil, case: str) -> None:
    qpos, qvel, moving = CASES[case]
    before = walker(env, qpos, qvel)
    num = round((0.2 if env is IMPLICIT else 0.04) / env.timestep)
    targets = swinging(env, num) if moving else np.zeros((num, 2))
    reference = Reference(env, np.asarray(before.qpos), np.asarray(before.qvel))
    for target in targets:
        reference.step(target)
    state = run(env, before, targets)
    assert not state.trial.diverged
    assert reference.touched == (case != "falling")
    assert reference.hit_limit == moving  # the motors' limit is at work
    data = reference.data
    # float32 keeps heights to 6e-8 m, so a sphere's spring of 150,000 N/m errs by 1e-2 N.
    np.testing.assert_allclose(state.qpos, data.qpos, atol=2e-4)
    np.testing.assert_allclose(state.qvel, data.qvel, atol=1e-2)
    np.testing.assert_allclose(state.stretch, reference.stretch, atol=1e-4)
    np.testing.assert_allclose(state.trial.torque_cost, reference.torque_cost, rtol=2e-3, atol=1e-2)
    mujoco.mj_forward(reference.model, data)
    # The walker's are those that the last step saw.
    np.testing.assert_allclose(state.own.height, data.subtree_com[1, 2], atol=4e-3)
    ankles = data.xpos[[data.body(f"foot_{leg}").id for leg in ("left", "right")]] - data.qpos[:3]
    np.testing.assert_allclose(state.ankle_x, ankles[:, 0], atol=6e-3)


def test_a_load_is_a_ball_of_that_mass_in_the_trunk() -> None:
    drawn = IMPLICIT.terrain.drawn(jnp.zeros((1, 6)).at[0, 4].set(0.75))
    before = walker(IMPLICIT, IN_THE_AIR, TUMBLING)
    reference = Reference(IMPLICIT, IN_THE_AIR, TUMBLING, load=6.0)
    targets = swinging(IMPLICIT, 100)
    for target in targets:
        reference.step(target)
    after = run(IMPLICIT, before, targets, drawn.given(FIRST))
    np.testing.assert_allclose(after.qpos, reference.data.qpos, atol=2e-4)
    without = run(IMPLICIT, before, targets)
    assert np.abs(np.asarray(without.qpos - after.qpos)).max() > 5e-4


def test_xla_steps_as_lanes_do() -> None:
    before = walker(IMPLICIT, qvel=0.2 * TUMBLING)
    theirs = jax.jit(IMPLICIT.step)(before, HipTargets(jnp.array([0.3, -0.2])), FLAT)
    ours = run(IMPLICIT, before, np.array([[0.3, -0.2]]))
    np.testing.assert_allclose(ours.qpos, theirs.qpos, atol=1e-6)
    # In 1 ms; float32 resolves accelerations to 1e-4 of some 1,000 rad/s^2.
    np.testing.assert_allclose(ours.qvel, theirs.qvel, atol=1e-3)
    np.testing.assert_array_equal(ours.touching, theirs.touching)


def test_free_flight_keeps_momentum_and_energy() -> None:
    before, num = walker(LIMP, IN_THE_AIR, TUMBLING), 2000
    after = run(LIMP, before, np.zeros((num, 2)))
    assert not after.trial.diverged
    one, other = mechanics(LIMP, before), mechanics(LIMP, after)
    mass, time = LIMP.weight / GRAVITY, num * LIMP.timestep
    fallen = one["linear"] - np.array([0.0, 0.0, mass * GRAVITY * time])
    # Rounding adds up to 2,000 steps x 6e-8 x 200 kg m/s at the very worst.
    np.testing.assert_allclose(other["linear"], fallen, atol=3e-2)
    np.testing.assert_allclose(other["angular"], one["angular"], atol=2e-2)
    # The step's own error: 0.05 ms of some 300 J of kinetic energy turning over in 0.1 s.
    np.testing.assert_allclose(other["energy"], one["energy"], atol=0.3)


def mechanics(env: Reil, state: State) -> dict[str, Any]:
    """Momenta about the centre of mass and energy, by C MuJoCo."""
    model = env.model.mujoco
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = state.qpos, state.qvel
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
    sign = np.ones(14)
    sign[[1, 3, 5]] = -1.0  # y, yaw, roll
    return np.asarray(values)[[*range(6), *range(10, 14), *range(6, 10)]] * sign


def test_a_mirrored_state_makes_the_mirrored_motion() -> None:
    targets = swinging(IMPLICIT, 150)
    one = walker(IMPLICIT, qvel=0.2 * TUMBLING)
    other = walker(IMPLICIT, mirrored(one.qpos), mirrored(one.qvel))
    one = run(IMPLICIT, one, targets)
    other = run(IMPLICIT, other, targets[:, ::-1])
    assert abs(one.qpos[3]) > 0.001
    # Sums over the legs run in another order; contact carries that rounding on.
    np.testing.assert_allclose(mirrored(other.qpos), one.qpos, atol=2e-4)
    np.testing.assert_allclose(other.ankle_x[::-1], one.ankle_x, atol=2e-4)


def test_varied_starts_move_over_feet_that_stand() -> None:
    draws = np.array([[1.0, -1.0, 0.5, 1.0, 0.0, 0.0]], np.float32)
    state = IMPLICIT.reset(IMPLICIT.terrain.drawn(jnp.asarray(draws)).given(FIRST))
    model = IMPLICIT.model.mujoco
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = state.qpos, state.qvel
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.qvel[:2], [0.2, -0.1], rtol=1e-6)
    pressed = 0.0
    for index, leg in enumerate(("left", "right")):
        foot = model.body(f"foot_{leg}").id
        np.testing.assert_allclose(state.ankle_x[index], data.xpos[foot, 0], atol=1e-6)
        np.testing.assert_allclose(data.xmat[foot].reshape(3, 3), np.eye(3), atol=1e-6)
        moving = np.zeros(6)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, foot, moving, 0)
        np.testing.assert_allclose(moving[1], 0.0, atol=1e-6)  # does not pitch
        # On the ground it is carried along neither forward nor, below the hips, sideways.
        np.testing.assert_allclose(moving[3], 0.0, atol=1e-6)
        assert abs(moving[4]) < 0.02
        for end in ("heel", "toe"):
            pressed += 0.08 - data.geom(f"{end}_{leg}").xpos[2]
    np.testing.assert_allclose(pressed * IMPLICIT.contact.stiffness, IMPLICIT.weight, rtol=1e-3)


def test_body_has_the_papers_sizes_and_densities() -> None:
    env = Reil()
    model = env.model.mujoco
    ball = 4.0 / 3.0 * np.pi
    foot = 2 * 1000 * ball * 0.08**3
    leg = 1000 * (ball * 0.125**3 + 0.175**2 * 0.5 + 0.125**2 * 0.54) + foot
    np.testing.assert_allclose(env.weight / GRAVITY, 500 * 0.5 * 0.5 * 0.6 + 2 * leg)
    np.testing.assert_allclose(model.body_iquat, np.tile([1.0, 0, 0, 0], (model.nbody, 1)))
    assert model.nv == 14 and env.floating.mujoco.nv == 14
    np.testing.assert_allclose(model.body_mass, env.floating.mujoco.body_mass)
    # Steiner: two balls apart.
    across = 0.4 * foot * 0.08**2 + foot * (0.5 * (env.toe - env.heel)) ** 2
    np.testing.assert_allclose(model.body("foot_left").inertia[1:], across)


def test_every_rule_of_a_trial_ends_it() -> None:
    env = IMPLICIT
    standing = walker(env, STANDING)
    targets = np.zeros((1, 2))
    assert not run(env, standing, targets).trial.done
    lying = standing._replace(qpos=standing.qpos.at[2].set(-0.9))
    flying = standing._replace(qpos=standing.qpos.at[2].add(0.2))
    flying = counted(flying, flight_time=jnp.float32(9.0))
    turned = standing._replace(qpos=standing.qpos.at[3].set(-1.01))
    for state in (lying, flying, turned):
        after = run(env, state, targets).trial
        assert after.fell and after.done and not after.diverged
    there = standing._replace(qpos=standing.qpos.at[0].set(20.1))
    late = counted(standing, num_steps=jnp.int32(39_999))
    late = late._replace(qpos=standing.qpos.at[0].set(15.0))
    stalled = counted(standing, num_steps=jnp.int32(6_100))  # 6 s for 0.25 m/s to be 1.5 m ahead
    still = standing._replace(own=standing.own._replace(still_time=jnp.float32(9.0)))
    for state in (there, late, stalled, still):
        after = run(env, state, targets).trial
        assert after.done and not after.fell
    restless = run(env, still, np.full((1, 2), 0.1))
    assert not restless.trial.done


def test_who_falls_before_a_step_is_done_has_no_fitness() -> None:
    env = Reil()
    state = walker(env, STANDING)
    near, far = (state._replace(qpos=state.qpos.at[0].set(x)) for x in (0.2, 3.0))
    assert env.fitness(counted(near, fell=jnp.ones((), bool))) == 0.0
    np.testing.assert_allclose(env.fitness(near), 0.2)
    # The hindmost foot counts.
    astride = counted(far, fell=jnp.ones((), bool))
    astride = astride._replace(ankle_x=jnp.array([0.3, -0.4]))
    np.testing.assert_allclose(env.fitness(astride), 2.6, rtol=1e-6)


@pytest.mark.parametrize("absurd", [np.nan, np.inf])
def test_physics_that_diverges_ends_the_walker_at_its_last_sound_state(absurd: float) -> None:
    before = walker(IMPLICIT)
    after = run(IMPLICIT, before, np.full((1, 2), absurd))
    assert np.isfinite(after.qpos).all() and np.isfinite(after.trial.torque_cost)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"timestep": 0.0}, "timestep must be a number above 0, got 0.0"),
        ({"knee_damping": -1.0}, "knee_damping must be 0 or above, got -1.0"),
        ({"integrator": "rk4"}, 'integrator must be "implicit" or "explicit", got "rk4"'),
        ({"toe": -0.2}, "toe must be ahead of heel, -0.079 m, got -0.2"),
        ({"knee_extension": 3.0}, "knee_extension must be below knee_flexion, 2.0 rad, got 3.0"),
    ],
)
def test_wrong_settings_are_refused(
    settings: dict[str, Any], message: str, unchecked_types: None
) -> None:
    with pytest.raises(ValueError, match=message):
        Reil(**settings)
