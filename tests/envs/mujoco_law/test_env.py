"""Tests of trials under MuJoCo's contacts, against C MuJoCo with the file as it is.

What C MuJoCo steps here is compiled from the file itself, so that its joints, floor and motors are
not those that the law makes of it.
"""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from mujoco_bodies import SMALL

from mjxwalk.engines import lanes
from mjxwalk.envs import TRIAL_AXES, Course, MjcfEnv, Payload, Push, Slope, Stretches, Trials
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mujoco_law.settings import MujocoContact

# A step is traced some times as fast.
pytestmark = pytest.mark.usefixtures("unchecked_types")
TRUNK, HEIGHT = 1, 0.4  # number of the body, and where the file has it, m
LENIENT: dict[str, Any] = {
    "contact_law": "mujoco",
    "solver": MujocoContact(iterations=50, ls_iterations=20),
    "min_height": 0.01,
    "max_pitch": 3.0,
    "max_flight_time": 9.0,
    "max_lag": 9.0,
}
PUSH = Push(speed=0.4, duration=0.0333, begin=0.0, every=0.5)
PAYLOAD = Payload(share=0.3, spread=0.3, forward=-0.03, up=0.1)
# m and rad; float32 of a metre, over some dozen steps of MuJoCo's contacts, which hit and let go.
CLOSE = 1e-5


def walked(env: MjcfEnv, values: Any, state: Any, given: Any) -> tuple[Any, Any]:
    """Returns the last state, and positions before each step [walker, step, coordinate].

    Args:
      env: body and ground.
      values: what motors are asked for [step, motor].
      state: of the walkers.
      given: their trials.
    """

    last, places = walking(env)(state, values, given)
    return last, np.asarray(places)


@functools.cache
def walking(env: MjcfEnv) -> Any:
    """Returns the function that walks."""

    def walk(state: Any, values: Any, given: Any) -> Any:
        return jax.lax.scan(lambda at, each: (env.step(at, each, given), at.qpos), state, values)

    return lanes.vmap(walk, (0, None, TRIAL_AXES))


def started(env: MjcfEnv, trials: Trials) -> tuple[Any, Any]:
    """Returns states of walkers at the start, and their trials."""
    given = trials.given(np.arange(trials.num))
    reset = jax.vmap(env.reset, in_axes=(TRIAL_AXES,))
    return jax.tree.map(np.array, reset(given)), given


def strides(num: int) -> Any:
    """Returns what motors are asked for in so many steps: one stride after the other."""
    swing = np.sin(0.2 * np.arange(num))
    return np.stack([0.5 * swing, -0.4 * swing], axis=1).astype(np.float32)


def own_model(env: MjcfEnv) -> Any:
    """Returns the `mujoco.MjModel` of the file, its motors to be set, its solver converged."""
    model = mujoco.MjModel.from_xml_string(env.body)
    model.opt.iterations, model.opt.tolerance = 200, 1e-12
    model.actuator_biastype[:] = mujoco.mjtBias.mjBIAS_AFFINE
    model.actuator_gainprm[:] = 0.0
    model.actuator_forcelimited[:], model.actuator_forcerange[:] = True, model.actuator_ctrlrange
    return model


def c_walked(env: MjcfEnv, model: Any, start: Any, values: Any, force: Any = None) -> Any:
    """Returns the positions that C MuJoCo comes to [step, coordinate].

    Args:
      env: whose motors are set.
      model: from `own_model`.
      start: coordinates at the start.
      values: what motors are asked for [step, motor].
      force: from the number of a step to the force on the trunk's centre, N.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = start
    data.qpos[1] -= HEIGHT
    places: list[Any] = []
    for number, each in enumerate(values):
        places.append(data.qpos + [0.0, HEIGHT, 0.0, 0.0, 0.0])
        torque, target, stiffness, damping = map(np.asarray, env.scaled_action(jnp.asarray(each)))
        bias = np.stack([torque + stiffness * target, -stiffness, -damping], axis=1)
        model.actuator_biasprm[:, :3] = bias
        if force is not None:
            data.xfrc_applied[TRUNK, :3] = force(number)
        mujoco.mj_step(model, data)
    return np.array(places)


def loaded(model: Any, payload: Payload, mass: float) -> Any:
    """Returns the same with a point mass on the trunk; contacts are as soft as without it."""
    spec = mujoco.MjSpec.from_string(SMALL)
    place = model.body_ipos[TRUNK] + payload.offset
    # Contacts go by the weight of a body that has no load; a mass of nothing is set afterwards.
    body = spec.body("trunk").add_body(name="load", pos=place)
    body.explicitinertial, body.ipos = True, np.zeros(3)
    body.mass, body.inertia = 1e-12, np.full(3, 1e-12)
    found = spec.compile()
    for name in ("actuator_biastype", "actuator_gainprm", "actuator_forcelimited"):
        getattr(found, name)[:] = getattr(model, name)
    found.actuator_forcerange[:] = model.actuator_forcerange
    found.opt.iterations, found.opt.tolerance = 200, 1e-12
    load = found.body("load").id
    found.body_mass[load] = mass
    found.body_subtreemass[[0, TRUNK, load]] += mass
    return found


def test_pushes_and_payloads_are_forces_and_masses_of_c_mujoco() -> None:
    env = MjcfEnv.of(SMALL, push=PUSH, payload=PAYLOAD, **LENIENT)
    values, starts = strides(80), np.array([0.02, 0.11, 0.02, 0.11], np.float32)
    change = np.array([0.0, 0.4, 0.0, 0.4], np.float32)
    pushes = np.stack([starts, change, 0 * change], axis=1)[:, None]
    load = np.array([-1.0, -1.0, 1.0, 0.5], np.float32)  # from nothing to 0.6 of its mass
    trials = env.level_trials(4)._replace(push=pushes, load=load)
    _, places = walked(env, values, *started(env, trials))
    plain, mass = own_model(env), float(own_model(env).body_mass.sum())
    apart: list[Any] = []
    for walker in range(4):

        def force(step: int, walker: int = walker) -> Any:
            ends = np.clip(env.timestep * np.arange(step, step + 2) - starts[walker], 0, 0.0333)
            newtons = mass * change[walker] * np.diff(ends)[0] / (0.0333 * env.timestep)
            return [newtons, 0.0, 0.0]

        carried = mass * 0.3 * (1.0 + float(load[walker]))
        model = plain if carried == 0.0 else loaded(plain, PAYLOAD, carried)
        expected = c_walked(env, model, places[walker, 0], values, force)
        np.testing.assert_allclose(places[walker], expected, atol=CLOSE)
        apart.append(expected[-1])
    for one, other in ((0, 1), (0, 2), (2, 3)):
        assert np.abs(apart[one] - apart[other]).max() > 1000 * CLOSE


def test_slopes_and_other_soil_are_planes_with_such_friction() -> None:
    gradient, slippery, soft = 0.1, 0.25, 0.5
    course = Course(
        slope=Slope(gradient=gradient, begin=0.0), soft=Stretches(factor=soft), length=6.4
    )
    env, values = MjcfEnv.of(SMALL, course=course, **LENIENT), strides(60)
    # Nodes by hand: level, level and slippery, a slope, a slope that is soft and slippery.
    table = np.ones((4, course.num_nodes, 3), np.float32)
    table[..., 0] = 0.0
    table[2:, :, 0] = gradient * course.spacing * np.arange(course.num_nodes)
    table[1:, :, 2], table[2, :, 2] = slippery, 1.0
    table[3, :, 1] = soft
    state, given = started(env, env.level_trials(4)._replace(course=table))
    middle = 2.0  # m; before x = 0 a course has no slope
    state.qpos[:, 0] += middle
    state.own.mujoco.qpos[:, 0] += middle
    state.qpos[2:, 1] += gradient * middle
    state.own.mujoco.qpos[2:, 1] += gradient * middle
    _, places = walked(env, values, state, given)
    for walker in range(4):
        model = own_model(env)
        floor = model.geom("floor").id
        if walker >= 2:
            half = -0.5 * np.arctan(gradient)
            model.geom_sameframe[floor] = 0  # or C MuJoCo takes the body's axes for the geom's
            model.geom_quat[floor] = [np.cos(half), 0.0, np.sin(half), 0.0]
        model.geom_friction[:, 0] *= table[walker, 0, 2]
        # MuJoCo's usual 0.02 s and damping ratio of 1, as stiffness and damping that are scaled.
        stiffness, damping = (table[walker, 0, 1] * each for each in (0.02**-2, 2.0 / 0.02))
        model.geom_solref[:] = -stiffness, -damping
        expected = c_walked(env, model, places[walker, 0], values)
        np.testing.assert_allclose(places[walker], expected, atol=CLOSE, err_msg=str(walker))
    ends = places[:, -1, 0]
    assert np.abs(np.diff(ends)).min() > 100 * CLOSE


@pytest.mark.slow
def test_the_ground_carries_a_standing_body_and_one_that_falls_has_fallen() -> None:
    env = MjcfEnv.of(SMALL, **{**LENIENT, "max_pitch": 0.8, "min_height": 0.75})
    state, given = started(env, env.level_trials(2))
    state, _ = walked(env, np.zeros((250, 2), np.float32), state, given)
    assert not state.trial.done.any() and state.touching.all()
    forces = lanes.vmap(env.ground_forces, (0, TRIAL_AXES))(state, given)
    total = np.asarray(forces)[0].sum(axis=0)
    # Of what is left of landing, a body that sways by some mm/s^2.
    np.testing.assert_allclose(total, [0.0, 0.0, env.weight], atol=0.01 * env.weight)
    state, _ = walked(env, np.ones((250, 2), np.float32), state, given)
    assert state.trial.done.all() and state.trial.fell.all() and not state.trial.diverged.any()
    assert abs(state.qpos[0, 2]) > 0.8 or state.qpos[0, 1] < 0.75 * env.stance.height
