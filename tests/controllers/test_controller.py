"""Tests of what a controller that says no more than it has to is taken for."""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import experiments
from mjxwalk.controllers import Controller
from mjxwalk.controllers.controller import Description, missing
from mjxwalk.envs import Action


class Gains(NamedTuple):
    """Two leaves."""

    push: Any
    tempo: Any


@dataclasses.dataclass(frozen=True)
class Plain(Controller):
    """Says what its weights are and what it does."""

    def template(self) -> Gains:
        """Returns zeros."""
        return Gains(jnp.zeros((2, 3)), jnp.zeros(()))

    def act(self, genotype: Gains, memory: Any, observation: Any, /) -> tuple[Any, Action]:
        """Returns its weights as torques."""
        del observation
        nothing = jnp.zeros(6)
        return memory, Action(genotype.push.reshape(-1), nothing, nothing, nothing)


def test_all_weights_are_there_none_may_go_and_all_are_of_one_network() -> None:
    plain = Plain()
    assert plain.init(plain.template()) == ()
    for found, kind, value in (
        (plain.mask(), bool, True),
        (plain.prunable(), int, -1),
        (plain.networks(), int, 0),
    ):
        assert jax.tree.structure(found) == jax.tree.structure(plain.template())
        assert [leaf.shape for leaf in found] == [(2, 3), ()]
        for leaf in found:
            assert leaf.dtype == jnp.zeros((), kind).dtype
            np.testing.assert_array_equal(leaf, value)


def test_the_weights_are_told_by_leaf_and_place() -> None:
    table = Plain().weight_table(Gains(np.arange(6.0).reshape(2, 3), np.float32(0.5)))
    assert table[0] == ("weights", "push", "0 0", 0.0)
    assert table[5] == ("weights", "push", "1 2", 5.0)
    assert table[6] == ("weights", "tempo", "", 0.5)
    assert len(table) == 7


def test_there_is_nothing_to_describe_and_nothing_to_scale() -> None:
    plain = Plain()
    assert plain.describe() == Description((), (), "")
    assert plain.scaled(2.0) is plain


def test_what_an_object_lacks_is_named() -> None:
    assert missing(Plain()) == []
    needed = set(missing(object()))
    assert {"template", "act", "init", "mask", "prunable", "networks"} <= needed
    assert not any(name.startswith("_") for name in needed)

    class Half:
        """Has all but one, of no kind of ours."""

    for name in needed - {"act"}:
        setattr(Half, name, lambda self: None)
    assert missing(Half()) == ["act"]


def test_experiments_take_any_controller_and_name_what_one_lacks() -> None:
    lpd = experiments.get("planar-lpd")
    assert dataclasses.replace(lpd, controller=Plain()).template().push.shape == (2, 3)
    with pytest.raises(ValueError, match=r"controller int has no template, act, .*; derive it"):
        dataclasses.replace(lpd, controller=3)
