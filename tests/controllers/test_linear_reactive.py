"""Tests of linear reactive control."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.controllers import LinearReactive, Memory, Weights
from mjxwalk.controllers.linear_reactive import (
    DAMPING,
    INPUTS,
    NETWORKS,
    SHORTEST_BLEND,
    STIFFNESS,
    local_links,
    scaled_inputs,
    sense,
    stance_leg,
)
from mjxwalk.envs import PlanarObservation

LPD = LinearReactive()
FIL = LinearReactive(links="all")
LEFT, RIGHT = Memory(jnp.asarray(True)), Memory(jnp.asarray(False))


def observation(**changes: Any) -> PlanarObservation:
    values: dict[str, Any] = {
        "time": 9.0,
        "pitch": 0.1,
        "pitch_rate": 0.5,
        "angle": [[0.3, 0.4, -0.1], [-0.2, 0.05, 0.15]],
        "rate": [[1.0, -2.0, 0.5], [-0.7, 0.2, 0.9]],
        "contact": [False, True],
        "ankle_x": [0.2, -0.1],
    } | changes
    return PlanarObservation(**{name: jnp.asarray(value) for name, value in values.items()})


def mirrored(seen: PlanarObservation) -> PlanarObservation:
    def swap(array: Any) -> Any:
        return array[::-1]

    return seen._replace(
        angle=swap(seen.angle),
        rate=swap(seen.rate),
        contact=swap(seen.contact),
        ankle_x=swap(seen.ankle_x),
    )


def random_weights(controller: LinearReactive, seed: int = 0) -> Weights:
    keys = iter(jax.random.split(jax.random.key(seed), 4))
    return jax.tree.map(
        lambda leaf: 0.3 * jax.random.normal(next(keys), leaf.shape), controller.template()
    )


def test_lpd_has_18_links_and_fil_96() -> None:
    assert int(LPD.mask().walking.sum()) == 18
    assert int(FIL.mask().walking.sum()) == 96
    links = local_links()
    for network in NETWORKS:
        seen = [
            name for name, link in zip(INPUTS, links[NETWORKS.index(network)], strict=True) if link
        ]
        assert seen == [network, f"{network} rate", "bias"]


def test_angles_by_role_are_those_worked_out_by_hand() -> None:
    senses = sense(observation(), jnp.asarray(False))  # right leg stands
    np.testing.assert_allclose(
        senses.angle, [0.1, -0.2 - 0.1, 0.3 + 0.2, 0.05, 0.4, 0.15, -0.1], rtol=1e-6
    )
    np.testing.assert_allclose(
        senses.rate, [0.5, -0.7 - 0.5, 1.0 + 0.7, 0.2, -2.0, 0.9, 0.5], rtol=1e-6
    )
    assert not senses.double_stance
    inputs = scaled_inputs(senses)
    np.testing.assert_allclose(inputs[INPUTS.index("swing knee")], (0.4 - 0.5) / 0.6, rtol=1e-5)
    assert inputs[INPUTS.index("bias")] == 1.0


@pytest.mark.parametrize(
    ("contact", "ankle_x", "before", "left_stands"),
    [
        ([True, False], [0.3, 0.0], False, True),
        ([False, True], [-0.3, 0.0], True, False),
        ([True, True], [-0.3, 0.0], False, True),
        ([True, True], [0.3, 0.0], True, False),
        ([False, False], [0.3, 0.0], True, True),
        ([False, False], [-0.3, 0.0], False, False),
    ],
)
def test_stance_is_the_leg_on_the_ground_or_the_trailing_one(
    contact: list[bool], ankle_x: list[float], before: bool, left_stands: bool
) -> None:
    seen = observation(contact=contact, ankle_x=ankle_x)
    assert bool(stance_leg(seen.contact, seen.ankle_x, jnp.asarray(before))) is left_stands


def test_torso_output_is_the_net_torque_of_both_hips() -> None:
    weights = random_weights(FIL)
    _, action = FIL.act(weights, LEFT, observation())
    inputs = scaled_inputs(sense(observation(), jnp.asarray(False)))
    torso, inter_leg = 100.0 * (weights.walking @ inputs)[:2]
    np.testing.assert_allclose(action.torque[0] + action.torque[3], torso, rtol=1e-4)
    np.testing.assert_allclose(action.torque[0], inter_leg, rtol=1e-4)  # left swings
    # Whatever the swing hip does, the torso feels the torso's network only.
    busier = weights._replace(walking=weights.walking.at[1].multiply(3.0))
    _, other = FIL.act(busier, LEFT, observation())
    np.testing.assert_allclose(other.torque[0] + other.torque[3], torso, rtol=1e-3)


def test_mirrored_senses_make_the_mirrored_action() -> None:
    weights = random_weights(FIL)
    for seen, memory, other in ((observation(), LEFT, RIGHT), (observation(), RIGHT, LEFT)):
        kept, action = FIL.act(weights, memory, seen)
        kept_mirrored, reflection = FIL.act(weights, other, mirrored(seen))
        np.testing.assert_allclose(np.roll(reflection.torque, 3), action.torque, rtol=1e-6)
        assert bool(kept.left_stance) is not bool(kept_mirrored.left_stance)


def test_masked_links_have_no_say() -> None:
    weights = random_weights(FIL)
    local = jax.tree.map(jnp.where, LPD.mask(), weights, LPD.template())
    for memory in (LEFT, RIGHT):
        _, with_others = LPD.act(weights, memory, observation())
        _, without = LPD.act(local, memory, observation())
        np.testing.assert_array_equal(with_others.torque, without.torque)
        _, all_links = FIL.act(local, memory, observation())
        np.testing.assert_allclose(all_links.torque, without.torque, rtol=1e-5)


def test_weights_move_linearly_from_initiation_to_walking() -> None:
    weights = random_weights(FIL)._replace(blend_time=jnp.asarray(-0.6))
    end = SHORTEST_BLEND + 0.6
    torques = [
        FIL.act(weights, RIGHT, observation(time=time))[1].torque
        for time in (0.0, 0.25 * end, end, 5.0)
    ]
    np.testing.assert_allclose(torques[1], 0.75 * torques[0] + 0.25 * torques[2], atol=1e-4)
    np.testing.assert_array_equal(torques[2], torques[3])
    only_initiation = weights._replace(walking=weights.initiation)
    np.testing.assert_allclose(
        FIL.act(only_initiation, RIGHT, observation())[1].torque, torques[0], atol=1e-4
    )


def test_torque_is_cut_at_the_limit() -> None:
    huge = jax.tree.map(lambda leaf: 1e3 * leaf, random_weights(FIL))
    _, action = FIL.act(huge, RIGHT, observation())
    limits = np.array([300.0, 300.0, 300.0, 600.0, 300.0, 300.0])  # stance hip: torso - inter-leg
    assert np.all(np.abs(action.torque) <= limits)
    assert np.sum(np.abs(action.torque) == 300.0) >= 4


def test_desired_angles_drive_each_joint_by_its_own_gains() -> None:
    controller = LinearReactive(links="all", output="angle")
    weights = random_weights(controller)
    assert weights.gains is not None
    seen = observation()
    _, action = controller.act(weights, RIGHT, seen)
    gains = np.exp(weights.gains)
    # Right leg stands: its knee is network 2, its ankle 4; the left knee is network 3, ankle 5.
    np.testing.assert_allclose(action.stiffness[4], STIFFNESS[2] * gains[2, 0], rtol=1e-5)
    np.testing.assert_allclose(action.stiffness[2], STIFFNESS[5] * gains[5, 0], rtol=1e-5)
    np.testing.assert_allclose(action.damping[1], DAMPING[3] * gains[3, 1], rtol=1e-5)
    outputs = weights.walking @ scaled_inputs(sense(seen, jnp.asarray(False)))
    np.testing.assert_allclose(action.target[1], 0.5 + 0.6 * outputs[3], rtol=1e-4)
    torso = STIFFNESS[0] * gains[0, 0] * (0.3 * outputs[0] - 0.1) - DAMPING[0] * gains[0, 1] * 0.5
    np.testing.assert_allclose(action.torque[0] + action.torque[3], torso, rtol=1e-4)
    assert action.torque[1] == 0.0 and action.stiffness[0] == 0.0


def test_networks_and_mask_have_the_shape_of_a_genotype() -> None:
    for controller in (LPD, FIL, LinearReactive(output="angle")):
        shapes = jax.tree.map(jnp.shape, controller.template())
        assert jax.tree.map(jnp.shape, controller.mask()) == shapes
        assert jax.tree.map(jnp.shape, controller.networks()) == shapes


def test_wrong_settings_are_refused(unchecked_types: None) -> None:
    with pytest.raises(ValueError, match="links must be local, all or a table .* got 'some'"):
        LinearReactive(links="some")  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="output must be one of torque, angle, got 'force'"):
        LinearReactive(output="force")  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(
    ("table", "complaint"),
    [
        ({"hip": ("bias",)}, "links has no network 'hip'"),
        ({"torso": ("stance thig",)}, "links of torso has no input 'stance thig'; did you mean"),
    ],
)
def test_a_wrong_table_of_links_is_one_sentence(
    table: dict[str, tuple[str, ...]], complaint: str
) -> None:
    with pytest.raises(ValueError, match=complaint) as caught:
        LinearReactive(links=table)
    assert "\n" not in str(caught.value)


def test_a_table_adds_its_links_to_the_local_ones() -> None:
    controller = LinearReactive(links={"torso": ("inter-leg", "bias"), "swing knee": ()})
    links = np.asarray(controller.mask().walking)
    added = np.argwhere(links & ~local_links()).tolist()
    assert added == [[NETWORKS.index("torso"), INPUTS.index("inter-leg")]]
    assert links[local_links()].all()
    assert hash(controller) == hash(LinearReactive(links={"torso": ("inter-leg", "bias")}))
    # Of all the weights the masked ones alone have no say.
    weights = random_weights(FIL)
    present = jax.tree.map(jnp.where, controller.mask(), weights, controller.template())
    _, some = controller.act(weights, RIGHT, observation())
    _, same = FIL.act(present, RIGHT, observation())
    np.testing.assert_allclose(some.torque, same.torque, rtol=1e-5)


def test_what_can_be_pruned_is_each_network_s_view_of_what_is_not_its_own() -> None:
    links = FIL.prunable()
    numbers = np.asarray(links.walking)
    np.testing.assert_array_equal(links.initiation, numbers)  # a link is in both sets of weights
    np.testing.assert_array_equal(numbers >= 0, ~local_links())
    assert sorted(numbers[numbers >= 0]) == list(range(6 * 13))
    assert links.blend_time == -1 and links.gains is None
    assert np.all(np.asarray(LPD.prunable().walking) == -1)
    gains = LinearReactive(links="all", output="angle").prunable().gains
    assert gains is not None and np.all(gains == -1)
