"""How a network is wired: layers of units, and the weights that connect one layer to another.

From that follow its links, which pruning takes out one by one, the layer that each weight belongs
to, and tables and drawings of what is left of it. A link is all weights by which a unit reads
another one: of a gated unit those of all its gates.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.controllers.controller import Description
from mjxwalk.runs.trees import flatten


class Layer(NamedTuple):
    """Units that stand side by side.

    Attributes:
      name: of the layer.
      units: their names.
    """

    name: str
    units: tuple[str, ...]


class Connection(NamedTuple):
    """A matrix of weights between two layers: a row for each unit that reads, or for each gate.

    Attributes:
      leaf: its name in the genotype, as `runs.trees.flatten` gives it.
      source: name of the layer that is read.
      target: name of the layer that reads.
      gates: of the target's units, one block of rows after the other; ("",) for none.
    """

    leaf: str
    source: str
    target: str
    gates: tuple[str, ...] = ("",)


class Wiring(NamedTuple):
    """A network's layers, those that are read first in front, and what connects them.

    Attributes:
      layers: all of them.
      connections: the weights that are links.
      others: name of the layer of each other leaf, such as its biases; one that is not named is the
        last layer's.
    """

    layers: tuple[Layer, ...]
    connections: tuple[Connection, ...]
    others: Mapping[str, str] = {}

    def layer(self, name: str) -> Layer:
        """Returns a layer by its name."""
        return next(layer for layer in self.layers if layer.name == name)

    def rows(self, connection: Connection) -> tuple[str, ...]:
        """Returns what each row of a connection's weights is."""
        units = self.layer(connection.target).units
        return tuple(f"{unit} {gate}".strip() for gate in connection.gates for unit in units)


def units(name: str, what: str, num: int) -> Layer:
    """Returns a layer of so many units, called by what they are and their numbers from 1."""
    return Layer(name, tuple(f"{what} {number}" for number in range(1, num + 1)))


def ends(description: Description) -> tuple[Layer, Layer]:
    """Returns the layer of the senses, with the clock's inputs if there are such, and that of the
    motors that have weights of their own.
    """
    seen = tuple(each.name for each in description.inputs)
    return Layer("senses", seen), Layer("motors", tuple(e.name for e in description.networks))


class Matrix(NamedTuple):
    """The weights of a connection in a genotype.

    Attributes:
      connection: which.
      weights: [row, column]; those that are no links are 0.
      present: whether there is a link.
    """

    connection: Connection
    weights: Float[np.ndarray, "row column"]
    present: Bool[np.ndarray, "row column"]


def number_links(wiring: Wiring, present: Any) -> Any:
    """Returns the number of each weight's link, -1 where it is none, in a genotype's shapes.

    Args:
      wiring: of the network.
      present: which weights are there.
    """
    first: dict[tuple[str, str], int] = {}
    numbers = {
        name: np.full(np.shape(leaf), -1, np.int32) for name, leaf in flatten(present).items()
    }
    start = 0
    for connection in wiring.connections:
        pair = connection.source, connection.target
        shape = [len(wiring.layer(name).units) for name in reversed(pair)]
        if pair not in first:
            first[pair], start = start, start + shape[0] * shape[1]
        block = first[pair] + np.arange(shape[0] * shape[1]).reshape(shape)
        numbers[connection.leaf][:] = np.tile(block, (len(connection.gates), 1))
    return _as_tree(
        present,
        {name: np.where(leaf, numbers[name], -1) for name, leaf in flatten(present).items()},
    )


def number_layers(wiring: Wiring, template: Any) -> Any:
    """Returns the number of the layer of each weight, from 0 without gaps, in a genotype's shapes.

    A layer's weights are those by which it reads others, its biases and the like.
    """
    names = [layer.name for layer in wiring.layers]
    readers = {connection.leaf: connection.target for connection in wiring.connections}
    of_leaf = {
        name: names.index(readers.get(name) or wiring.others.get(name, names[-1]))
        for name in flatten(template)
    }
    used = sorted(set(of_leaf.values()))
    return _as_tree(
        template,
        {
            name: np.full(np.shape(leaf), used.index(of_leaf[name]), np.int32)
            for name, leaf in flatten(template).items()
        },
    )


def matrices(wiring: Wiring, genotype: Any, present: Any) -> list[Matrix]:
    """Returns the weights of each connection; a weight of exactly 0 may have been pruned."""
    weights, there = flatten(genotype), flatten(present)
    return [
        Matrix(connection, np.where(there[leaf], weights[leaf], 0.0), there[leaf])
        for connection in wiring.connections
        for leaf in [connection.leaf]
    ]


def table(wiring: Wiring, genotype: Any, present: Any) -> list[tuple[str, str, str, float]]:
    """Returns a genotype as rows of leaf, unit, unit that it reads or "", and value; links only."""
    weights, there = flatten(genotype), flatten(present)
    known = {connection.leaf: connection for connection in wiring.connections}
    rows: list[tuple[str, str, str, float]] = []
    for leaf, values in weights.items():
        for place in np.argwhere(there[leaf]).tolist():
            value = float(values[tuple(place)])
            if leaf in known:
                connection = known[leaf]
                source = wiring.layer(connection.source).units[place[1]]
                rows.append((leaf, wiring.rows(connection)[place[0]], source, value))
            else:
                rows.append((leaf, " ".join(map(str, place)), "", value))
    return rows


def _as_tree(like: Any, leaves: Mapping[str, np.ndarray]) -> Any:
    return jax.tree.unflatten(jax.tree.structure(like), [leaves[name] for name in flatten(like)])
