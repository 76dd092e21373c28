"""Tests of cutting trials into strides."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from analysis.walking import FRAME, STANCE_FRAMES, STRIDE_FRAMES, stand, walk

from mjxwalk.analysis.strides import debounced, find_strides, role_periods, stance_leg
from mjxwalk.controllers import linear_reactive


def test_strides_of_a_known_gait_have_its_numbers() -> None:
    strides = find_strides(*walk())
    # Touch-downs of the left foot at 1.2, 2.4 ... 4.8 s, of the right one at 0.6, 1.8 ... 5.4 s.
    np.testing.assert_allclose(strides.start, [0.6, 1.2, 1.8, 2.4, 3.0, 3.6, 4.2])
    np.testing.assert_array_equal(strides.foot, [1, 0, 1, 0, 1, 0, 1])
    np.testing.assert_allclose(strides.duration, 1.2)
    np.testing.assert_allclose(strides.length, 1.2)
    np.testing.assert_allclose(strides.step_length, 0.6)
    np.testing.assert_allclose(strides.speed, 1.0)
    np.testing.assert_allclose(strides.double_stance, 0.2)
    np.testing.assert_allclose(strides.swing_time, 0.48)


def test_steps_of_a_limp_are_told_apart() -> None:
    time, contact, ankle_x = walk()
    ankle_x = ankle_x + [0.0, 0.1]
    strides = find_strides(time, contact, ankle_x)
    np.testing.assert_allclose(strides.step_length[strides.foot == 0], 0.5)
    np.testing.assert_allclose(strides.step_length[strides.foot == 1], 0.7)
    np.testing.assert_allclose(strides.length, 1.2)


def test_chatter_in_the_contacts_is_ignored() -> None:
    time, contact, ankle_x = walk()
    noisy = contact.copy()
    for foot, shift in ((0, 0), (1, STRIDE_FRAMES // 2)):
        phase = (np.arange(len(time)) + shift) % STRIDE_FRAMES
        bounces = np.isin(phase, (1, 3, 4, STANCE_FRAMES - 3, STANCE_FRAMES - 2))
        scuffs = np.isin(phase, (95, 96, 108))
        noisy[bounces, foot] = False
        noisy[scuffs, foot] = True
    assert (noisy != contact).sum() > 50
    np.testing.assert_array_equal(debounced(noisy, time), contact)
    for ours, clean in zip(
        find_strides(time, debounced(noisy, time), ankle_x),
        find_strides(time, contact, ankle_x),
        strict=True,
    ):
        np.testing.assert_array_equal(ours, clean)


def test_phases_as_long_as_the_shortest_stay() -> None:
    time = FRAME * np.arange(40)
    contact = np.ones((40, 1), bool)
    contact[10:15] = False  # exactly 0.05 s
    contact[30:34] = False
    cleaned = debounced(contact, time, shortest=0.05)[:, 0]
    np.testing.assert_array_equal(np.flatnonzero(~cleaned), [10, 11, 12, 13, 14])


def test_a_short_phase_at_the_end_counts_as_what_came_before() -> None:
    time, contact = FRAME * np.arange(40), np.zeros((40, 1), bool)
    contact[38:] = True
    assert not debounced(contact, time).any()


@pytest.mark.parametrize("frames", [1, 2, 600])
def test_a_standing_walker_takes_no_strides(frames: int) -> None:
    strides = find_strides(*stand(frames))
    assert all(len(column) == 0 for column in strides)
    assert len(strides.speed) == 0


def test_one_frame_of_walking_has_no_strides() -> None:
    time, contact, ankle_x = walk(1)
    assert len(find_strides(time, debounced(contact, time), ankle_x).end) == 0
    assert len(role_periods(stance_leg(contact, ankle_x))) == 0


def test_no_stride_is_made_of_a_hop_or_a_stumble() -> None:
    time, contact, ankle_x = walk()
    hop = contact.copy()
    hop[170:260, 1] = False  # the right foot does not touch down at 1.8 s
    assert len(find_strides(time, hop, ankle_x).end) == 7 - 3
    stumble = contact.copy()
    stumble[200:210, 1] = False  # and here it does so twice, at 1.8 and 2.1 s
    found = find_strides(time, stumble, ankle_x)
    assert 1.2 not in found.start.round(2)


def test_longer_stance_makes_more_double_stance() -> None:
    strides = find_strides(*walk(stance=78))
    np.testing.assert_allclose(strides.double_stance, 2 * (78 - 60) / 120)


def test_stance_leg_is_the_controllers() -> None:
    draws = np.random.default_rng(0)
    contact, ankle_x = draws.random((200, 2)) < 0.5, draws.normal(size=(200, 2))
    before: Any = jnp.zeros((), bool)
    expected: list[bool] = []
    for touches, ankles in zip(contact, ankle_x, strict=True):
        before = linear_reactive.stance_leg(jnp.asarray(touches), jnp.asarray(ankles), before)
        expected.append(bool(before))
    np.testing.assert_array_equal(stance_leg(contact, ankle_x), expected)


def test_roles_change_as_the_foot_behind_lifts_off() -> None:
    _, contact, ankle_x = walk()
    left = stance_leg(contact, ankle_x)
    periods = role_periods(left)
    # The right foot lifts off at 12, the left one at 72, and so on in turn.
    np.testing.assert_array_equal(periods[:3], [[12, 72], [72, 132], [132, 192]])
    assert left[12:72].all() and not left[72:132].any()
