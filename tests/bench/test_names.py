"""Tests of the names of bodies."""

import pytest

from mjxwalk.bench import bodies, names
from mjxwalk.errors import RunError


def test_all_leaves_out_what_is_measured_on_request_alone() -> None:
    found = names.chosen(["all"])
    assert set(names.BODIES) - set(found) == set(names.ON_REQUEST)
    assert names.chosen(["all", *names.ON_REQUEST]) == tuple(names.BODIES)


def test_names_are_in_order_and_each_once() -> None:
    assert names.chosen(["h1", "planar7", "h1"]) == ("planar7", "h1")


def test_a_wrong_name_is_told_with_the_nearest() -> None:
    with pytest.raises(RunError, match="has no planar8; did you mean planar7"):
        names.chosen(["planar8"])


def test_every_name_has_a_body() -> None:
    assert list(names.BODIES) == list(bodies.MAKERS)
