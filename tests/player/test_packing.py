"""Tests of how series are made small."""

import base64
import gzip

import numpy as np

from mjxwalk.player import packing
from mjxwalk.player.packing import Series

WAVES = np.sin(np.linspace(0, 30, 400)[None] * np.array([[1.0], [3.0]])) * [[1.0], [200.0]]


def test_what_is_unpacked_is_within_half_a_step() -> None:
    stored, text = packing.pack({"waves": Series(WAVES, 0.01), "line": Series(WAVES[:1], 0.5)})
    found = packing.unpack(stored, text)
    assert np.abs(found["waves"] - WAVES).max() <= 0.005 + 1e-9
    assert np.abs(found["line"] - WAVES[:1]).max() <= 0.25 + 1e-9


def test_a_jump_that_does_not_fit_makes_the_steps_coarser() -> None:
    jump = np.array([[0.0, 1e6, -1e6, 3.0]])
    stored, text = packing.pack({"jump": Series(jump, 1e-3)})
    step = stored["jump"].step
    assert 1e-3 < step < 100.0
    assert np.abs(packing.unpack(stored, text)["jump"] - jump).max() <= 0.5 * step + 1e-6


def test_bytes_are_as_the_page_reads_them() -> None:
    _, text = packing.pack({"steps": Series(np.array([[1.0, -1.0, 299.0]]), 1.0)})
    # differences 1, -2 and 300, high bytes first, by hand
    assert gzip.decompress(base64.b64decode(text)) == bytes([0, 255, 1, 1, 254, 44])


def test_the_same_numbers_make_the_same_text() -> None:
    first = packing.pack({"waves": Series(WAVES, 0.01)})
    assert packing.pack({"waves": Series(WAVES.copy(), 0.01)}) == first


def test_no_places_are_no_bytes() -> None:
    stored, text = packing.pack({"none": Series(np.zeros((3, 0)), 0.1)})
    assert packing.unpack(stored, text)["none"].shape == (3, 0)
