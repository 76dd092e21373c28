"""Tests that our side and C MuJoCo's do the same work: model, starts, policies and trials."""

import dataclasses
import functools
from typing import Any

import numpy as np
import pytest

from mjxwalk.bench import bodies, c_contenders, contenders
from mjxwalk.bench.contact_bodies import HELD, WEIGHT_SIGMA, ContactBody
from mjxwalk.engines import lanes
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.gymnasium import files

# A step is traced some times as fast.
pytestmark = pytest.mark.usefixtures("unchecked_types")
ACTIONS = 20  # steps of control, 100 of the physics


def planar7() -> ContactBody:
    body = bodies.get("planar7")
    assert isinstance(body, ContactBody)
    return body


@functools.cache
def walked_by_lanes(size: int) -> Any:
    engine = contenders.Engine(lanes.vmap, planar7().workload(size))
    assert engine(ACTIONS) == size * ACTIONS * HELD
    return engine.walked


def test_both_sides_come_to_the_same_place() -> None:
    """From the same starts, by the same policies, each of which sees its own walker."""
    loop = c_contenders.ClosedLoop(planar7(), 64, 2)
    qpos, qvel = loop.walked(ACTIONS)
    ours = walked_by_lanes(64).walk
    assert np.ptp(qpos[:, 3], axis=0) > 1e-3  # walkers differ
    # The median in float32; one iteration leaves a few, whose feet slip as they land, further off.
    assert np.median(np.abs(ours.qpos - qpos).max(1)) < 1e-6
    assert np.mean(np.abs(ours.qpos - qpos).max(1) < 1e-3) > 0.9
    assert np.median(np.abs(ours.qvel - qvel).max(1)) < 1e-4


def test_nobody_leaves_early_and_contacts_are_met() -> None:
    assert bodies.num_stopped(walked_by_lanes(64)) == 0
    seen = c_contenders.ClosedLoop(planar7(), 8, 2).observe()
    assert 3.0 < seen.contacts <= 4.0  # of a body that stands on four spheres
    assert seen.warnings == 0


def test_walkers_that_diverged_are_counted() -> None:
    walked = walked_by_lanes(64)
    qpos = walked.walk.qpos.copy()
    qpos[[3, 5], 0] = np.nan, np.inf
    assert bodies.num_stopped(walked._replace(walk=walked.walk._replace(qpos=qpos))) == 2


def test_a_rollout_repeats_the_trials_of_the_closed_loop() -> None:
    replay: Any = c_contenders.Replay(planar7(), 8, 2)
    steps = 8 * planar7().num_actions * HELD
    assert replay(1) == steps
    loop = c_contenders.ClosedLoop(planar7(), 8, 2)
    assert loop(1) == steps and loop(2) == 2 * steps
    qpos, _ = loop.walked(planar7().num_actions)
    # Both are C MuJoCo in float64; the states of a rollout begin with the time.
    np.testing.assert_allclose(replay._passed[:, -1, 1:10], qpos, atol=1e-9)


def test_numpy_and_jax_compute_the_same_control() -> None:
    body = dataclasses.replace(planar7(), hidden=(8, 8))
    genotypes, starts = body.genotypes(5), body.starts(5)
    found = body.controls(genotypes, starts.qpos, starts.qvel)
    walker = lanes.vmap(body.control)(genotypes, starts.qpos, starts.qvel)
    np.testing.assert_allclose(found, walker, rtol=1e-5, atol=1e-4)
    assert found.std(axis=0).max() > 0.0
    assert [layer.weights.shape for layer in genotypes] == [(5, 8, 17), (5, 8, 8), (5, 6, 8)]
    assert float(np.std(genotypes[-1].weights)) == pytest.approx(WEIGHT_SIGMA, rel=0.2)


@pytest.mark.parametrize(
    ("name", "file"), [("walker2d", "walker2d_v5.xml"), ("humanoid", "humanoid.xml")]
)
def test_c_mujoco_steps_gymnasiums_body_as_it_is(name: str, file: str) -> None:
    pytest.importorskip("gymnasium")
    body = bodies.get(name)
    assert isinstance(body, ContactBody)
    ours, own = body.c_model(), mujoco.MjModel.from_xml_string(files.text(file))
    for each in ("body_mass", "body_inertia", "geom_size", "geom_friction", "geom_contype",
                 "geom_conaffinity", "dof_damping", "dof_armature", "jnt_range"):  # fmt: skip
        np.testing.assert_allclose(getattr(ours, each), getattr(own, each), atol=1e-12)
    assert ours.opt.timestep == own.opt.timestep
    torques = np.abs(own.actuator_gear[:, 0] * own.actuator_ctrlrange[:, 1])
    np.testing.assert_allclose(np.sort(ours.actuator_forcerange[:, 1]), np.sort(torques))
    assert (ours.opt.iterations, ours.opt.ls_iterations, int(ours.opt.integrator)) == (1, 4, 0)


def test_a_body_can_have_the_options_of_its_file() -> None:
    pytest.importorskip("gymnasium")
    body = bodies.get("walker2d", file_options=True)
    assert isinstance(body, ContactBody) and not body.is_straight
    options = body.c_model().opt
    assert int(options.integrator) == int(mujoco.mjtIntegrator.mjINT_RK4)
    assert options.iterations == 100  # as MuJoCo has it


def test_operations_are_those_of_a_step_and_a_fifth_of_the_control() -> None:
    body = planar7()
    assert body.sizes == (17, 6) and body.control_operations == 2 * 17 * 6
    assert body.operations(1204) == 1000 + round(204 / HELD)
    wide = dataclasses.replace(body, hidden=(64, 64))
    assert wide.operations(1204) == 1000 + round(2 * (17 * 64 + 64 * 64 + 64 * 6) / HELD)
