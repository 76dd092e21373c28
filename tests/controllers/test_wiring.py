"""Links and layers of networks: what belongs together, and that a link is what it says it is."""

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
    wiring,
)
from mjxwalk.envs import MjcfEnv
from mjxwalk.runs.trees import flatten

ENV = MjcfEnv.of(robots.text("walker2d"))
POLICIES = [
    policy.on(ENV)
    for policy in (
        LinearFeedback(rates=True),
        Mlp(hidden=(4, 3)),
        Mlp(hidden=(4, 3), layer_norm=True),
        RecurrentNetwork(cell="elman", units=3),
        RecurrentNetwork(units=3),
        PatternGenerator(neurons=4),
        PatternGenerator(neurons=4, feels=False),
        Harmonics(),
    )
]
every_policy = pytest.mark.parametrize("policy", POLICIES, ids=lambda each: type(each).__name__)


def drawn(policy: Policy) -> Any:
    """Returns a genotype in which no weight is 0."""
    draws = np.random.default_rng(0)
    return jax.tree.map(
        lambda leaf: jnp.asarray(draws.uniform(0.2, 0.9, size=leaf.shape), jnp.float32),
        policy.weights(),
    )


def respond(policy: Policy, genotype: Any, seen: Any) -> Any:
    """Returns what motors are asked for after three actions of the same senses."""
    memory = policy.recall(genotype)
    rows: Any = None
    for _ in range(3):
        memory, rows = policy.respond(genotype, memory, seen, jnp.array([0.7, 0.7 + np.pi]))
    return np.asarray(rows)


@every_policy
def test_a_link_of_a_sense_is_all_by_which_a_unit_reads_it(policy: Policy) -> None:
    # Without its links to all units, a sense no longer changes what motors are asked for.
    plan = policy.wiring()
    seen = jnp.asarray(np.random.default_rng(1).normal(size=(2, len(policy.layout.inputs))))
    other = seen.at[:, 1].add(1.0)
    genotype, numbers = drawn(policy), flatten(policy.prunable())
    reading = [each for each in plan.connections if each.source == "senses"]
    gone = {int(n) for each in reading for n in numbers[each.leaf][:, 1] if n >= 0}
    feels = bool(gone)
    assert feels == (not isinstance(policy, Harmonics) and getattr(policy, "feels", True))
    pruned = jax.tree.map(
        lambda leaf, links: jnp.where(np.isin(links, list(gone)), 0.0, leaf),
        genotype,
        policy.prunable(),
    )
    changed = ~np.isclose(respond(policy, genotype, seen), respond(policy, genotype, other))
    assert changed.any() == feels
    np.testing.assert_array_equal(respond(policy, pruned, seen), respond(policy, pruned, other))


@every_policy
def test_links_are_pairs_of_units_and_biases_stay(policy: Policy) -> None:
    numbers, there = flatten(policy.prunable()), flatten(policy.present())
    plan = policy.wiring()
    links = {connection.leaf for connection in plan.connections}
    pairs: dict[int, set[tuple[str, str]]] = {}
    for connection in plan.connections:
        shape = numbers[connection.leaf].shape
        source, target = plan.layer(connection.source), plan.layer(connection.target)
        assert shape == (len(plan.rows(connection)), len(source.units))
        for (row, column), number in np.ndenumerate(numbers[connection.leaf]):
            assert (number >= 0) == there[connection.leaf][row, column]
            unit = target.units[row % len(target.units)]
            pair = f"{target.name} {unit}", f"{source.name} {source.units[column]}"
            pairs.setdefault(int(number), set()).add(pair)
    pairs.pop(-1, None)
    assert all(len(pair) == 1 for pair in pairs.values())
    assert len({next(iter(pair)) for pair in pairs.values()}) == len(pairs)
    for name, leaf in numbers.items():
        assert name in links or np.all(leaf == -1), name


def test_gates_share_their_units_links() -> None:
    policy = RecurrentNetwork(units=3).on(ENV)
    numbers = np.asarray(policy.prunable().units)
    np.testing.assert_array_equal(numbers[:3], numbers[3:6])
    np.testing.assert_array_equal(numbers[:3], numbers[6:])
    assert len(np.unique(numbers)) == 9
    assert policy.wiring().rows(policy.wiring().connections[1])[3] == "unit 1 update"


def test_layers_of_a_perceptron_are_numbered_with_their_biases_and_gains() -> None:
    layers = Mlp(hidden=(4, 3), layer_norm=True).on(ENV).networks()
    for number in range(3):
        assert np.all(layers.weights[number] == number)
        assert np.all(layers.biases[number] == number)
    assert np.all(layers.gains[1] == 1)
    assert np.all(layers.direct == 2) and layers.pace == 2


@pytest.mark.parametrize(
    ("policy", "num"),
    [(LinearFeedback(), 1), (Harmonics(), 1), (PatternGenerator(), 2), (RecurrentNetwork(), 2)],
)
def test_other_networks_have_so_many_layers(policy: Policy, num: int) -> None:
    found = np.concatenate([np.ravel(leaf) for leaf in jax.tree.leaves(policy.on(ENV).networks())])
    np.testing.assert_array_equal(np.unique(found), np.arange(num))


@every_policy
def test_every_weight_that_is_there_is_told_once(policy: Policy) -> None:
    genotype = drawn(policy)
    rows = policy.weight_table(genotype)
    assert len(rows) == sum(int(np.sum(leaf)) for leaf in jax.tree.leaves(policy.present()))
    assert len({row[:3] for row in rows}) == len(rows)


def test_a_row_of_the_table_says_what_reads_what() -> None:
    policy = LinearFeedback().on(ENV)
    genotype = policy.template()._replace(weights=jnp.zeros_like(policy.template().weights))
    genotype = genotype._replace(weights=genotype.weights.at[1, 0].set(0.25))
    motor, sense = policy.wiring().layer("motors").units[1], policy.layout.inputs[0]
    assert ("weights", motor, sense, 0.25) in policy.weight_table(genotype)
    assert ("bias", "1", "", 0.0) in policy.weight_table(genotype)


def test_what_is_known_of_normalised_senses_is_no_link() -> None:
    policy = Mlp(hidden=(4, 3), normalise=True).on(ENV)
    plain = Mlp(hidden=(4, 3)).on(ENV)
    for found, expected, rest in (
        (policy.prunable(), plain.prunable(), -1),
        (policy.networks(), plain.networks(), 0),
    ):
        assert jax.tree.map(np.array_equal, found.weights, expected) == jax.tree.map(
            lambda leaf: True, expected
        )
        assert all(np.all(leaf == rest) for leaf in found.senses)
    assert policy.weight_table(policy.template()) == plain.weight_table(plain.template())


def test_matrices_hold_the_weights_of_connections() -> None:
    policy = PatternGenerator(neurons=4, feels=False).on(ENV)
    genotype = drawn(policy)
    found = wiring.matrices(policy.wiring(), genotype, policy.present())
    by_leaf = {matrix.connection.leaf: matrix for matrix in found}
    np.testing.assert_array_equal(by_leaf["motors"].weights, genotype.motors)
    assert not by_leaf["senses"].present.any() and not by_leaf["senses"].weights.any()
