"""Links that a policy has left, read off its genotype, and how they are drawn."""

from typing import Any

import numpy as np
import pytest

from mjxwalk import robots
from mjxwalk.analysis import networks
from mjxwalk.controllers import Mlp, PatternGenerator, RecurrentNetwork
from mjxwalk.controllers.wiring import Layer
from mjxwalk.envs import MjcfEnv
from mjxwalk.runs.trees import flatten, unflatten

ENV = MjcfEnv.of(robots.text("walker2d"))


def genotype(policy: Any, **leaves: Any) -> Any:
    """Returns weights of zero, but for some leaves."""
    zeros = {name: np.zeros(leaf.shape) for name, leaf in flatten(policy.template()).items()}
    arrays = {name: np.asarray(leaf, np.float32) for name, leaf in (zeros | leaves).items()}
    return unflatten(policy.template(), arrays)


def by_leaf(policy: Any, genotype: Any) -> dict[str, networks.Links]:
    return {each.leaf: each for each in networks.links_of(policy, genotype)}


def test_links_are_the_weights_that_are_not_zero() -> None:
    policy = Mlp(hidden=(3, 2)).on(ENV)
    weights = np.zeros((2, 3))
    weights[1, 2], weights[0, 0] = -0.5, 2.0
    found = by_leaf(policy, genotype(policy, **{"weights.1": weights}))
    assert list(found) == ["weights.0", "weights.1", "weights.2", "direct"]
    middle = found["weights.1"]
    assert (middle.source.name, middle.target.name) == ("hidden 1", "hidden 2")
    np.testing.assert_array_equal(middle.left, weights != 0)
    assert not found["direct"].left.any()
    assert found["direct"].weight.shape == (len(policy.rows), len(policy.layout.inputs) + 2)


def test_a_gated_link_is_its_largest_weight() -> None:
    policy = RecurrentNetwork(units=2, cell="gru").on(ENV)
    shape = flatten(policy.template())
    (leaf,) = [
        each.leaf for each in policy.wiring().connections if each.source == each.target == "units"
    ]
    weights = np.zeros(shape[leaf].shape)
    gates = weights.reshape(-1, 2, 2)
    gates[0, 1, 0], gates[1, 1, 0] = 0.3, -0.7
    weight = by_leaf(policy, genotype(policy, **{leaf: weights}))[leaf].weight
    np.testing.assert_allclose(weight, [[0, 0], [-0.7, 0]], rtol=1e-6)


def test_layers_that_cannot_be_connected_are_left_out() -> None:
    policy = PatternGenerator(neurons=3, feels=False).on(ENV)
    assert "senses" not in by_leaf(policy, policy.template())


def test_a_network_is_drawn_link_by_link() -> None:
    layers = Layer("a", ("one", "two")), Layer("b", ("three",)), Layer("c", ("four", "five"))
    links = [
        networks.Links("w", layers[0], layers[1], np.array([[1.0, -2.0]])),
        networks.Links("x", layers[1], layers[1], np.array([[0.5]])),
        networks.Links("y", layers[0], layers[2], np.array([[0.0, 4.0], [0.0, 0.0]])),
    ]
    axis: Any = networks.drawn(layers, links).axes[0]
    (lines,) = axis.collections[:1]
    # The weakest first, as the strongest lie on top.
    ends = [(path.vertices[0].tolist(), path.vertices[-1].tolist()) for path in lines.get_paths()]
    assert ends == [
        ([1.0, 0.5], [1.0, 0.5]),
        ([0.0, 0.75], [1.0, 0.5]),
        ([0.0, 0.25], [1.0, 0.5]),
        ([0.0, 0.25], [2.0, 0.75]),
    ]
    widths = np.array(lines.get_linewidths())
    assert widths[-1] == pytest.approx(networks.WIDEST)
    share = (widths - networks.THINNEST) / (networks.WIDEST - networks.THINNEST)
    np.testing.assert_allclose(share, [0.125, 0.25, 0.5, 1.0])
    blue, orange = lines.get_colors()[0], lines.get_colors()[2]
    assert [tuple(colour) for colour in lines.get_colors()] == list(
        map(tuple, [blue, blue, orange, blue])
    )
    names = [text.get_text() for text in axis.texts]
    assert names == ["a", "one", "two", "b", "c", "four", "five"]


def test_of_a_large_network_the_strongest_links_are_drawn() -> None:
    layers = Layer("a", ("",) * 60), Layer("b", ("",) * 60)
    weights = np.random.default_rng(0).normal(size=(60, 60))
    links = [networks.Links("w", *layers, weights)]
    lines: Any = networks.drawn(layers, links).axes[0].collections[0]
    assert len(lines.get_paths()) == networks.MOST_DRAWN
    assert networks.weakest_drawn(links) == np.sort(np.abs(weights).ravel())[-networks.MOST_DRAWN]


def test_a_network_without_links_is_its_units() -> None:
    layers = Layer("a", ("one",)), Layer("b", ("two",))
    links = [networks.Links("w", *layers, np.zeros((1, 1)))]
    assert len(networks.drawn(layers, links).axes[0].collections[0].get_paths()) == 0
