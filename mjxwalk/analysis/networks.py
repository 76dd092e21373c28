"""The network that is left of a policy: its links between units, counted and drawn."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from mjxwalk.analysis.figures import BEST, MEAN
from mjxwalk.controllers import Policy, wiring
from mjxwalk.controllers.wiring import Layer

POSITIVE, NEGATIVE = BEST, MEAN  # colours of links by the sign of their weight
MOST_DRAWN = 1500  # links; ours: more are no picture but a grey plane
MOST_NAMED = 48  # units of a layer; ours: more names than this lie over each other
WIDEST, THINNEST = 2.2, 0.25  # points, of the strongest link and of the weakest; ours
BEND, BOW = 0.28, 0.06  # how far links within a column, and over a column, are bent; ours
LOOP = np.array([0.05, 0.015])  # half the width and height of a unit's link to itself; ours
CURVE = np.linspace(0.0, 1.0, 24)[:, None]  # along a link that is bent


class Links(NamedTuple):
    """The links from one layer to another.

    Attributes:
      leaf: name of their weights in the genotype.
      source: the layer that is read.
      target: the layer that reads.
      weight: of each link [target, source]; of a gated unit that of its gates which is largest by
        amount; 0 where there is none.
    """

    leaf: str
    source: Layer
    target: Layer
    weight: Float[np.ndarray, "target source"]

    @property
    def left(self) -> Bool[np.ndarray, "target source"]:
        """Whether there is a link."""
        return self.weight != 0


def links_of(policy: Policy, genotype: Any) -> list[Links]:
    """Returns the links of a policy's genotype, of connected layers only."""
    plan, found = policy.wiring(), list[Links]()
    for matrix in wiring.matrices(plan, policy.weights_of(genotype), policy.present()):
        if not matrix.present.any():  # as the senses of a generator that feels nothing
            continue
        source, target = (
            plan.layer(name) for name in (matrix.connection.source, matrix.connection.target)
        )
        gates = matrix.weights.reshape(len(matrix.connection.gates), len(target.units), -1)
        strongest = np.abs(gates).argmax(axis=0)[None]
        weight = np.take_along_axis(gates, strongest, axis=0)[0]
        found.append(Links(matrix.connection.leaf, source, target, weight))
    return found


def drawn(layers: Sequence[Layer], links: Sequence[Links]) -> Figure:
    """Returns a picture of a network: layers as columns of units, links by weight and sign.

    Args:
      layers: left to right.
      links: between them; the strongest are drawn, see `MOST_DRAWN`.
    """
    most = max(len(layer.units) for layer in layers)
    figure = Figure(figsize=(9, 1.2 + 0.16 * np.clip(most, 8, 40)), layout="constrained")
    axis: Any = figure.subplots()
    places = {layer.name: _places(x, layer) for x, layer in enumerate(layers)}
    least, lines = weakest_drawn(links), list[tuple[float, Any]]()
    for each in links:
        ends = places[each.source.name], places[each.target.name]
        lines += [
            (float(each.weight[target, source]), _path(ends[0][source], ends[1][target]))
            for target, source in np.argwhere(each.left & (np.abs(each.weight) >= least))
        ]
    lines.sort(key=lambda line: abs(line[0]))  # the strongest on top
    weights = np.array([weight for weight, _ in lines])
    axis.add_collection(
        LineCollection(
            [path for _, path in lines],
            colors=[POSITIVE if weight > 0 else NEGATIVE for weight in weights],
            linewidths=THINNEST + (WIDEST - THINNEST) * np.abs(weights / weights[-1:]),
            alpha=0.75,
            zorder=1,
        )
    )
    for x, layer in enumerate(layers):
        _draw_units(axis, x, layer, places[layer.name], is_last=x == len(layers) - 1)
    axis.set(xlim=(-0.75, len(layers) - 0.25), ylim=(-BOW, 1.06 + BOW))
    axis.axis("off")
    return figure


def weakest_drawn(links: Sequence[Links]) -> float:
    """Returns the amount of the weakest weight that is drawn."""
    amounts = np.sort(np.concatenate([np.abs(each.weight[each.left]) for each in links] or [[]]))
    return float(amounts[-MOST_DRAWN:][0]) if len(amounts) else 0.0


def _places(x: int, layer: Layer) -> Float[np.ndarray, "unit 2"]:
    """Returns where a column's units are, the first at the top."""
    num = len(layer.units)
    heights = 1.0 - (np.arange(num) + 0.5) / num
    return np.stack([np.full(num, float(x)), heights], axis=1)


def _path(start: Any, end: Any) -> Any:
    """Returns the points of a link: straight to the next column, else in a bow."""
    gap = end[0] - start[0]
    if gap == 1:
        return np.stack([start, end])
    if np.array_equal(start, end):  # of a unit that reads itself
        turn = 2 * np.pi * CURVE
        return start + LOOP * np.hstack([np.cos(turn) - 1, np.sin(turn)])
    middle = (start + end) / 2
    # Within a column to the left of it, and over other columns away from their middles.
    out = [-BEND, 0.0] if gap == 0 else [0.0, BOW if middle[1] > 0.5 else -BOW]
    bent = middle + 2 * np.array(out)
    return (1 - CURVE) ** 2 * start + 2 * CURVE * (1 - CURVE) * bent + CURVE**2 * end


def _draw_units(axis: Any, x: int, layer: Layer, places: Any, *, is_last: bool) -> None:
    named = len(layer.units) <= MOST_NAMED and (x == 0 or is_last)
    size = float(np.clip(900 / len(layer.units), 4, 40))
    axis.scatter(*places.T, s=size, color="0.6", edgecolors="black", linewidths=0.6, zorder=3)
    axis.text(x, 1.01 + BOW, layer.name, ha="center", va="bottom", fontsize=9)
    for unit, (_, y) in zip(layer.units, places, strict=True):
        if named:
            side, where = (0.05, "left") if is_last else (-0.05, "right")
            axis.text(x + side, y, unit, ha=where, va="center", fontsize=6.5, zorder=4)
