"""What policies of any body share: mirror, hold and clock, on a robot with arms and a waist."""

import dataclasses
import itertools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import robots
from mjxwalk.controllers import (
    Harmonics,
    LinearFeedback,
    Mlp,
    PatternGenerator,
    Policy,
    RecurrentNetwork,
)
from mjxwalk.envs import BodyObservation, MjcfEnv
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import reader
from mjxwalk.rollout import rollout

H1 = MjcfEnv.of(reader.read(robots.path("h1")).text, max_time=0.1)
POLICIES: list[Policy] = [
    LinearFeedback(moved="all", rates=True),
    Mlp(moved="all", hidden=(5,)),
    Mlp(moved="all", hidden=(5, 4), activation="elu", layer_norm=True),
    RecurrentNetwork(moved="all", cell="elman", units=5),
    RecurrentNetwork(moved="all", units=5),
    Harmonics(moved="all"),
    PatternGenerator(moved="all"),
]
FLIPPED = {"up": (1, -1, 1), "turning": (-1, 1, -1), "velocity": (1, -1, 1), "heading": (-1,)}


def observation(key: int, time: float) -> BodyObservation:
    draws = np.random.default_rng(key)
    joints = len(H1.anatomy.coordinates) - 6
    return BodyObservation(
        time=jnp.asarray(time),
        **{name: jnp.asarray(draws.normal(size=len(signs))) for name, signs in FLIPPED.items()},
        angle=jnp.asarray(draws.normal(size=joints)),
        rate=jnp.asarray(draws.normal(size=joints)),
        contact=jnp.array([True, False]),
        ankle_x=jnp.array([0.1, -0.2]),
    )


def mirrored(seen: BodyObservation) -> BodyObservation:
    """Returns what the walker's mirror image senses, by the names of its joints alone."""
    names = [each.name for each in H1.anatomy.coordinates[6:]]
    pairs = {"left": "right", "right": "left"}
    words = [name.split("_", 1) for name in names]
    other = [names.index("_".join([pairs.get(first, first), *rest])) for first, *rest in words]
    # Axes along y keep their sense of turning, those along x and z change it.
    sign = np.array([-1 if any(w in n for w in ("yaw", "roll", "torso")) else 1 for n in names])
    flips = {name: getattr(seen, name) * np.array(signs) for name, signs in FLIPPED.items()}
    return seen._replace(
        **flips,
        angle=seen.angle[np.array(other)] * sign,
        rate=seen.rate[np.array(other)] * sign,
        contact=seen.contact[::-1],
        ankle_x=seen.ankle_x[::-1],
    )


def some_weights(policy: Policy) -> Any:
    leaves, tree = jax.tree.flatten(policy.template())
    keys = jax.random.split(jax.random.key(4), len(leaves))
    drawn = [
        0.02 * jax.random.normal(key, leaf.shape) for key, leaf in zip(keys, leaves, strict=True)
    ]
    return jax.tree.unflatten(tree, [a + b for a, b in zip(leaves, drawn, strict=True)])


@pytest.mark.parametrize("policy", POLICIES, ids=lambda policy: type(policy).__name__)
def test_mirror_image_half_a_period_later_does_the_mirrored(policy: Policy) -> None:
    policy = policy.on(H1)
    genotype = some_weights(policy)
    seen = observation(1, 0.0)
    pace = float(policy.pace(genotype))
    period = policy.layout.time / (0.364 * (1 + 0.25 * np.tanh(pace)))
    memory = policy.recall(genotype)
    _, ours = policy.decide(genotype, memory, policy.layout.read(seen), seen.time)
    later = mirrored(seen)._replace(time=jnp.asarray(0.5 * period))
    swapped = memory if memory is None else memory[::-1]
    _, theirs = policy.decide(genotype, swapped, policy.layout.read(later), later.time)
    motors = [H1.anatomy.coordinates[each.coordinate] for each in H1.anatomy.motors]
    places = [each.coordinate for each in H1.anatomy.motors]
    expected = [each.sign * float(theirs[places.index(each.mirror)]) for each in motors]
    np.testing.assert_allclose(ours, expected, atol=2e-5)
    assert np.abs(ours).max() > 0.01


@pytest.mark.parametrize("policy", POLICIES, ids=lambda policy: type(policy).__name__)
def test_action_is_held_for_its_period(policy: Policy) -> None:
    policy = dataclasses.replace(policy, period=0.006).on(H1)
    assert policy.layout.every == 3
    genotype = some_weights(policy)
    memory = policy.init(genotype)
    asked = []
    for step in range(7):
        memory, action = policy.act(genotype, memory, observation(step, 0.1 * step))
        asked.append(np.asarray(action))
    same = [bool(np.array_equal(one, other)) for one, other in itertools.pairwise(asked)]
    assert same == [True, True, False, True, True, False]


def test_legs_alone_move_while_arms_hold() -> None:
    policy = LinearFeedback().on(H1)
    assert policy.layout.outputs == tuple(
        f"{side}_{joint}"
        for side in ("left", "right")
        for joint in ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle")
    )
    seen = observation(2, 0.3)
    _, action = policy.decide(some_weights(policy), None, policy.layout.read(seen), seen.time)
    assert not np.asarray(action)[10:].any()


def test_template_bends_knee_and_hip_so_that_the_foot_rises() -> None:
    """The pose that half a lift asks for has a higher foot, by C MuJoCo's kinematics."""
    policy = LinearFeedback().on(H1)
    model = H1.model.mujoco
    data = mujoco.MjData(model)
    stance = np.asarray(H1.reset(H1.level_trials().given(0)).qpos, np.float64)
    data.qpos[:] = stance
    mujoco.mj_kinematics(model, data)
    before = data.body("left_ankle_link").xpos.copy(), data.body("left_ankle_link").xmat.copy()
    for name, lift in zip(policy.layout.outputs, policy.layout.lift, strict=True):
        if name.startswith("left"):
            data.qpos[H1.anatomy.place(name)] += lift
    mujoco.mj_kinematics(model, data)
    after = data.body("left_ankle_link")
    assert after.xpos[2] > before[0][2] + 0.05
    np.testing.assert_allclose(after.xmat, before[1], atol=0.02)  # level as it was


def test_harmonics_begin_as_half_a_sine() -> None:
    policy = Harmonics(harmonics=8).on(H1)
    phase = jnp.linspace(0.0, 2 * jnp.pi, 50)
    rows = [
        policy.respond(policy.template(), None, jnp.zeros((2, 1)), jnp.array([at, at + jnp.pi]))[1]
        for at in phase
    ]
    knee = policy.layout.outputs.index("left_knee")
    swing = np.array(rows)[:, 0, knee]
    expected = policy.layout.lift[knee] * np.maximum(np.sin(phase), 0.0)
    np.testing.assert_allclose(swing, expected, atol=0.03)


def test_generator_lifts_legs_in_turn_for_ever() -> None:
    policy = PatternGenerator().on(H1)
    genotype = policy.template()
    memory = policy.recall(genotype)
    respond = jax.jit(
        lambda memory: policy.respond(
            genotype, memory, jnp.zeros((2, len(policy.layout.inputs))), jnp.zeros(2)
        )
    )
    out = []
    for _ in range(1000):
        memory, rows = respond(memory)
        out.append(np.asarray(rows)[:, policy.layout.outputs.index("left_knee")])
    left, right = np.array(out)[500:].T
    assert np.corrcoef(left, right)[0, 1] < -0.5
    assert np.ptp(left) > 0.5 * 0.7 and np.ptp(right) > 0.5 * 0.7


@pytest.mark.parametrize("policy", POLICIES, ids=lambda policy: type(policy).__name__)
def test_rolls_out_on_a_planar_body(policy: Policy) -> None:
    env = MjcfEnv.of(reader.read(robots.path("walker2d")).text, max_time=0.05)
    policy = policy.on(env)
    outcome = jax.jit(lambda genotype, given: rollout(env, policy, genotype, given))(
        policy.template(), env.level_trials().given(0)
    )
    assert float(outcome.duration) == pytest.approx(0.05) and not bool(outcome.diverged)


@pytest.mark.parametrize(
    ("kind", "changes", "words"),
    [
        (LinearFeedback, {"period": 0.0}, "period"),
        (Mlp, {"hidden": ()}, "hidden"),
        (RecurrentNetwork, {"units": 0}, "units"),
        (Harmonics, {"harmonics": 0}, "harmonics"),
        (PatternGenerator, {"neurons": 1}, "neurons"),
    ],
)
def test_wrong_settings_are_refused(kind: Any, changes: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        kind(**changes)


@pytest.mark.usefixtures("unchecked_types")
@pytest.mark.parametrize(
    ("kind", "changes", "words"),
    [
        (Mlp, {"activation": "sine"}, "activation must be one of tanh, relu, elu"),
        (RecurrentNetwork, {"cell": "lstm"}, 'cell must be "elman" or "gru", got "lstm"'),
    ],
)
def test_words_that_are_not_known_are_refused(kind: Any, changes: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        kind(**changes)
