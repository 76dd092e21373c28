"""Any controller in any experiment: what it sees and moves of bodies with a class of their own."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import experiments
from mjxwalk.controllers import Policy
from mjxwalk.rollout import rollout

BODIES = ("planar-lpd", "solomon-3d", "reil-unassisted")
PAIRS = [
    # XLA takes half a minute for this body, whatever decides in it.
    pytest.param(body, name, marks=[pytest.mark.slow] if slow else [])
    for body in BODIES
    for name in experiments.CONTROLLERS
    for slow in [body == "reil-unassisted" and name != "recurrent"]
]


def of(body: str, controller: str) -> Any:
    experiment = experiments.get(f"{body}+{controller}")
    return dataclasses.replace(experiment, env=dataclasses.replace(experiment.env, max_time=0.05))


@pytest.mark.parametrize(("body", "controller"), PAIRS)
def test_every_controller_takes_every_body_of_ours(body: str, controller: str) -> None:
    experiment = of(body, controller)
    given = experiment.env.level_trials().given(0)
    outcome = rollout(experiment.env, experiment.controller, experiment.template(), given)
    assert int(outcome.steps) > 0
    assert np.isfinite(float(outcome.fitness))


@pytest.mark.parametrize("body", BODIES)
def test_inputs_of_our_bodies_are_their_senses_by_name(body: str) -> None:
    """Each input is read off a state whose numbers are all different."""
    experiment = of(body, "linear")
    env, policy = experiment.env, experiment.controller
    state = env.reset(env.level_trials().given(0))
    count = len(env.anatomy.coordinates)
    qpos = jnp.asarray(0.01 * np.arange(1, count + 1), jnp.float32)
    seen = env.observe(state._replace(qpos=qpos, qvel=10 * qpos))
    layout = policy.layout
    inputs = np.asarray(layout.read(seen)) * np.array(layout.scale) + np.array(layout.centre)
    names = env.anatomy.names
    for name, value in zip(layout.inputs, inputs, strict=True):
        kind, _, joint = name.partition(" ")
        if kind in ("angle", "rate"):
            place = names.index(joint)
            expected = float(qpos[place]) * (1 if kind == "angle" else 10)
        elif kind in ("adduction", "adduction_rate"):
            expected = float(qpos[names.index("adduction")]) * (1 if kind == "adduction" else 10)
        elif kind in ("pitch", "pitch_rate", "torso", "torso_rate"):
            turn = getattr(env.anatomy.root, joint or "pitch")
            expected = float(qpos[turn]) * (10 if kind.endswith("rate") else 1)
        else:
            assert kind == "contact"
            expected = float(seen.contact[0 if joint == "left" else 1])
        assert value == pytest.approx(expected, abs=1e-5), name


@pytest.mark.parametrize("body", BODIES)
def test_a_mirrored_state_leads_to_the_mirrored_action(body: str) -> None:
    experiment = of(body, "mlp")
    policy: Policy = dataclasses.replace(experiment.controller, clock=False).on(experiment.env)
    keys = iter(jax.random.split(jax.random.key(0), 20))
    genotype = jax.tree.map(
        lambda leaf: leaf + 0.3 * jax.random.normal(next(keys), leaf.shape), policy.template()
    )
    anatomy = experiment.env.anatomy
    partner = np.array([each.mirror for each in anatomy.coordinates])
    sign = np.array([each.sign for each in anatomy.coordinates], np.float32)
    draws = np.random.default_rng(0).normal(size=len(partner)).astype(np.float32)
    state = experiment.env.reset(experiment.env.level_trials().given(0))
    feet = np.array_split(np.arange(len(state.touching)), 2)
    touching = np.zeros(len(state.touching), bool)
    touching[feet[0]] = True
    one = state._replace(qpos=jnp.asarray(draws), qvel=jnp.asarray(-draws), touching=touching)
    other = one._replace(
        qpos=jnp.asarray(sign * draws[partner]),
        qvel=jnp.asarray(-sign * draws[partner]),
        touching=~touching,
    )
    actions = [
        np.asarray(policy.act(genotype, policy.init(genotype), experiment.env.observe(each))[1])
        for each in (one, other)
    ]
    driven = [each.coordinate for each in anatomy.motors]
    expected = [sign[each] * actions[0][driven.index(int(partner[each]))] for each in driven]
    np.testing.assert_allclose(actions[1], expected, atol=1e-5)
    assert np.abs(actions[0]).max() > 0.01
