"""Tests of linear reactive control in space."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.controllers import Memory, SpatialReactive, SpatialWeights
from mjxwalk.controllers.spatial_reactive import (
    ANGLES,
    DAMPING,
    INPUTS,
    NETWORKS,
    STIFFNESS,
    TARGET_HIGHEST,
    scaled_inputs,
    sense,
)
from mjxwalk.envs import SpatialObservation

SIL = SpatialReactive()
LPD = SpatialReactive(links="local")
FIL = SpatialReactive(links="all")
LEFT, RIGHT = Memory(jnp.asarray(True)), Memory(jnp.asarray(False))


def observation(**changes: Any) -> SpatialObservation:
    values: dict[str, Any] = {
        "time": 9.0,
        "torso": [0.2, 0.1, -0.03],  # yaw, pitch, roll
        "torso_rate": [0.4, 0.5, 0.3],
        "adduction": 0.06,
        "adduction_rate": -0.2,
        "angle": [[0.3, 0.4, -0.1, 0.02], [-0.2, 0.05, 0.15, -0.04]],
        "rate": [[1.0, -2.0, 0.5, 0.1], [-0.7, 0.2, 0.9, -0.3]],
        "contact": [False, True],
        "ankle_x": [0.2, -0.1],
    } | changes
    return SpatialObservation(**{name: jnp.asarray(value) for name, value in values.items()})


def mirrored(seen: SpatialObservation) -> SpatialObservation:
    """Swaps left and right: legs change places, yaw and roll their signs."""
    turned = jnp.array([-1.0, 1.0, -1.0])
    return seen._replace(
        torso=turned * seen.torso,
        torso_rate=turned * seen.torso_rate,
        angle=seen.angle[::-1],
        rate=seen.rate[::-1],
        contact=seen.contact[::-1],
        ankle_x=seen.ankle_x[::-1],
    )


def random_weights(seed: int = 0) -> SpatialWeights:
    keys = iter(jax.random.split(jax.random.key(seed), 2))
    return jax.tree.map(
        lambda leaf: 0.3 * jax.random.normal(next(keys), leaf.shape), SIL.template()
    )


def with_weight(network: str, name: str, value: float) -> SpatialWeights:
    links = jnp.zeros((len(NETWORKS), len(INPUTS)))
    place = NETWORKS.index(network), INPUTS.index(name)
    return SpatialWeights(links.at[place].set(value), jnp.zeros((len(NETWORKS), 2)))


def test_a_network_has_28_weights_and_sees_25_state_variables() -> None:
    # Solomon et al. (2013), section 2.5: 25 state variables, P and D gains, a bias; seven networks.
    assert len(INPUTS) == 25 + 1
    assert sum(int(leaf.sum()) for leaf in FIL.mask()) == 7 * 28 == 196
    assert int(LPD.mask().links.sum()) == 7 * 3
    # Section 2.7.3: the adduction has eight: its own two, and these.
    seen = np.asarray(SIL.mask().links)[NETWORKS.index("adduction")]
    names = {name for name, there in zip(INPUTS, seen, strict=True) if there} - {"bias"}
    angles = {"adduction", "roll", "yaw", "stance ankle", "stance ankle roll"}
    assert names == angles | {f"{angle} rate" for angle in angles}


def test_angles_by_role_are_those_worked_out_by_hand() -> None:
    senses = sense(observation(), jnp.asarray(False))  # right leg stands
    by_hand = {
        "torso": 0.1,
        "roll": -0.03,
        "yaw": 0.2,
        "stance thigh": -0.2 - 0.1,
        "inter-leg": 0.3 + 0.2,
        "stance knee": 0.05,
        "swing knee": 0.4,
        "stance ankle": 0.15,
        "swing ankle": -0.1,
        "adduction": 0.06,
        "stance ankle roll": -0.04,
        "swing ankle roll": 0.02,
    }
    assert tuple(by_hand) == ANGLES
    np.testing.assert_allclose(senses.angle, list(by_hand.values()), rtol=1e-6)
    inputs = scaled_inputs(senses)
    assert inputs[INPUTS.index("stance thigh")] == pytest.approx(-0.3 / 0.5)
    assert inputs[INPUTS.index("bias")] == 1.0
    # Left leg stands: roll and yaw are seen from its side.
    other = sense(observation(), jnp.asarray(True))
    np.testing.assert_allclose(other.angle[1:3], [0.03, -0.2], rtol=1e-6)
    np.testing.assert_allclose(other.rate[1:3], [-0.3, -0.4], rtol=1e-6)


def test_inputs_are_bounded() -> None:
    senses = sense(observation(torso_rate=[0.0, 1e6, 0.0]), jnp.asarray(False))
    assert scaled_inputs(senses)[INPUTS.index("torso rate")] == 3.0


@pytest.mark.parametrize("contact", [[False, True], [True, False], [True, True]])
def test_a_mirrored_walker_does_the_mirrored_thing(contact: list[bool]) -> None:
    weights, seen = random_weights(), observation(contact=contact)
    memory, action = FIL.act(weights, RIGHT, seen)
    other_memory, other = FIL.act(weights, LEFT, mirrored(seen))
    assert bool(memory.left_stance) is not bool(other_memory.left_stance)
    swapped = np.array([0, 4, 5, 6, 1, 2, 3])  # adduction, left leg, right leg
    for here, there in zip(action, other, strict=True):
        np.testing.assert_allclose(np.asarray(there)[swapped], here, rtol=1e-5, atol=1e-5)


def test_torque_on_the_torso_is_the_torso_network_s_alone() -> None:
    # Right leg stands. Both hips act on the torso with minus their own torque.
    weights = with_weight("torso", "bias", 0.2)
    seen = observation()
    _, action = LPD.act(weights, RIGHT, seen)
    left_hip, right_hip = action.torque[1], action.torque[4]
    wanted = STIFFNESS[0] * (0.3 * 0.2 - 0.1) - DAMPING[0] * 0.5
    assert float(left_hip + right_hip) == pytest.approx(float(wanted), rel=1e-5)
    inter_leg = STIFFNESS[1] * (0.0 - 0.5) - DAMPING[1] * (1.0 + 0.7)
    assert float(left_hip) == pytest.approx(float(inter_leg), rel=1e-5)


def test_limbs_are_driven_to_their_target_with_the_gains_of_their_network() -> None:
    weights = with_weight("swing knee", "bias", 0.5)._replace(
        gains=jnp.zeros((7, 2)).at[NETWORKS.index("swing knee")].set(jnp.log(jnp.array([2.0, 3.0])))
    )
    _, action = LPD.act(weights, RIGHT, observation())
    knee = 2  # of the left leg, which swings
    swing = NETWORKS.index("swing knee")
    assert float(action.target[knee]) == pytest.approx(0.6 * 0.5)
    assert float(action.stiffness[knee]) == pytest.approx(2 * float(STIFFNESS[swing]))
    assert float(action.damping[knee]) == pytest.approx(3 * float(DAMPING[swing]))
    assert float(action.torque[knee]) == 0.0
    _, action = LPD.act(with_weight("swing knee", "bias", 99.0), RIGHT, observation())
    assert float(action.target[knee]) == pytest.approx(float(TARGET_HIGHEST[swing]))


def test_a_weight_that_is_no_link_does_nothing() -> None:
    seen = observation()
    _, there = LPD.act(with_weight("torso", "roll", 5.0), RIGHT, seen)
    _, nothing = LPD.act(with_weight("torso", "roll", 0.0), RIGHT, seen)
    jax.tree.map(np.testing.assert_array_equal, there, nothing)


def test_what_can_be_pruned_is_every_link_but_the_local_ones() -> None:
    numbers = np.asarray(FIL.prunable().links)
    local = np.asarray(LPD.mask().links)
    assert (numbers[local] == -1).all()
    np.testing.assert_array_equal(np.sort(numbers[~local]), np.arange((~local).sum()))
    assert (np.asarray(FIL.prunable().gains) == -1).all()


def test_weights_are_told_by_network_and_input() -> None:
    rows = LPD.weight_table(with_weight("adduction", "bias", 0.25))
    assert len(rows) == 7 * 3 + 7 * 2
    assert ("walking", "adduction", "bias", 0.25) in rows
    assert ("gains", "torso", "stiffness", 0.0) in rows


@pytest.mark.parametrize(
    ("links", "complaint"),
    [
        ("some", "links must be local, all or a table"),
        ({"neck": ("roll",)}, "links has no network 'neck'"),
        ({"torso": ("rol",)}, "links of torso has no input 'rol'; did you mean roll"),
    ],
)
def test_wrong_links_are_refused(links: Any, complaint: str, unchecked_types: None) -> None:
    with pytest.raises(ValueError, match=complaint):
        SpatialReactive(links=links)
