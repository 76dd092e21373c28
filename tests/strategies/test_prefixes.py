"""Tests for settings that are spread over a template."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.strategies.prefixes import count_groups, match_template

TEMPLATE = {"hip": jnp.zeros((2, 3)), "legs": (jnp.zeros(2), jnp.zeros((), jnp.bfloat16))}


def test_one_value_reaches_every_weight_in_its_dtype():
    full = match_template("sigma", 2, TEMPLATE)
    np.testing.assert_array_equal(full["hip"], np.full((2, 3), 2.0))
    assert full["hip"].dtype == jnp.float32
    assert full["legs"][1].dtype == jnp.bfloat16


def test_a_prefix_gives_each_part_its_own_value_and_broadcasts():
    full = match_template("sigma", {"hip": np.array([1.0, 2.0, 3.0]), "legs": 4.0}, TEMPLATE)
    np.testing.assert_array_equal(full["hip"], [[1, 2, 3], [1, 2, 3]])
    np.testing.assert_array_equal(full["legs"][0], [4, 4])


@pytest.mark.parametrize("prefix", [{"hip": 1.0}, {"hip": 1.0, "legs": (1.0,)}, [1.0, 2.0]])
def test_a_structure_that_is_no_prefix_is_refused_by_name(prefix: Any):
    with pytest.raises(ValueError, match="sigma must be one value or a pytree prefix"):
        match_template("sigma", prefix, TEMPLATE)


def test_a_shape_that_does_not_broadcast_is_refused_by_place():
    with pytest.raises(ValueError, match=r"sigma\['hip'\] must broadcast .*\(2, 3\).*\(4,\)"):
        match_template("sigma", {"hip": np.ones(4), "legs": 1.0}, TEMPLATE)


def test_groups_are_counted():
    assert count_groups(0) == 1
    assert count_groups({"a": np.array([2, 0]), "b": 1}) == 3


@pytest.mark.parametrize("groups", [1, {"a": 0, "b": 2}, [-1, 0], 0.0, True, {}])
def test_groups_with_gaps_or_of_another_type_are_refused(groups: Any):
    if groups == {}:
        with pytest.raises(ValueError, match="groups"):
            match_template("groups", groups, TEMPLATE)
        return
    with pytest.raises(ValueError, match="groups must use every whole number"):
        count_groups(groups)
