"""The paper's figures from our runs; each function returns a matplotlib figure.

Solomon, Locascio & Hartmann (2013), Adaptive Behavior 21(1), doi 10.1177/1059712312462904, section
3. Figures are made without pyplot, so that nothing stays behind and no display is needed.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mjxwalk.analysis.angles import AngleDensity
from mjxwalk.analysis.curves import Curve, PhaseCurves
from mjxwalk.analysis.frame import Frame

NEAR, FAR, GROUND = "#1f4e8c", "#9db7d6", "#b9b3a6"  # left leg, right leg, terrain
BEST, MEAN = "#1f4e8c", "#c2571a"  # the fittest, the whole population
NARROW = 0.08  # of all generations; ours: fewer have no room for a phase's name across
COLOURS = ("#1f4e8c", "#c2571a", "#3f7f3f", "#7a4a8c")  # of groups that are compared


def fitness_over_phases(phases: Sequence[PhaseCurves], *, unit: str = "m") -> Figure:
    """Returns Figure 4a: the fittest and the mean with their deviations, phase after phase.

    Args:
      phases: from `curves.average_phase`, in their order; an empty one takes no room.
      unit: of the fitness; "" for none.
    """
    figure = Figure(figsize=(9, 4.5), layout="constrained")
    axis: Any = figure.subplots()
    start, bounds, centres = 0, [0], list[tuple[float, PhaseCurves]]()
    for phase in phases:
        if not len(phase):
            continue
        generations = start + 1 + np.arange(len(phase))
        first = start == 0
        _band(axis, generations, phase.best, BEST, "fittest" if first else None)
        _band(axis, generations, phase.mean, MEAN, "mean" if first else None)
        start += len(phase)
        bounds.append(start)
        centres.append((start - len(phase) / 2, phase))
    for bound in bounds[1:-1]:
        axis.axvline(bound + 0.5, color="0.6", linewidth=0.8, linestyle=":")
    for centre, phase in centres:
        _name_phase(axis, centre, phase, is_narrow=len(phase) < NARROW * start)
    axis.set(xlabel="generation", ylabel=fitness_label(unit), xlim=(0, max(start, 1)))
    start_at_zero(axis, *(curve.mean for phase in phases for curve in (phase.best, phase.mean)))
    if centres:
        axis.legend(loc="lower right", frameon=False)
    return figure


def fitness_label(unit: str) -> str:
    """Returns what stands at an axis of fitness; a unit of "" is none."""
    return f"fitness ({unit})" if unit else "fitness"


def start_at_zero(axis: Any, *curves: Float[np.ndarray, " _"]) -> None:
    """Lets the axis of values begin at zero, unless a value lies below it."""
    known = np.concatenate([np.zeros(1), *curves])
    if np.nanmin(known) >= 0.0:
        axis.set_ylim(0, None)


def _name_phase(axis: Any, centre: float, phase: PhaseCurves, *, is_narrow: bool) -> None:
    """Writes a phase's name and number of runs over its curves; upright where it is narrow."""
    runs = f"{phase.num_runs} run{'s' if phase.num_runs != 1 else ''}"
    axis.annotate(
        f"{phase.name}, {runs}" if is_narrow else f"{phase.name}\n{runs}",
        (centre, 1),
        xycoords=("data", "axes fraction"),
        xytext=(0, 3),
        textcoords="offset points",
        ha="center",
        fontsize=8,
        rotation="vertical" if is_narrow else "horizontal",
    )


def fitness_of_groups(groups: Sequence[PhaseCurves]) -> Figure:
    """Returns Figure 4b: the fittest and the mean of several kinds of runs in one frame.

    Args:
      groups: from `curves.average_phase`; the first is drawn thick, as RSIL in the paper.
    """
    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axis: Any = figure.subplots()
    for place, group in enumerate(groups):
        generations = 1 + np.arange(len(group))
        style = {"color": COLOURS[place % len(COLOURS)], "linewidth": 2.2 if place == 0 else 1.0}
        label = f"{group.name}, {group.num_runs} run{'s' if group.num_runs != 1 else ''}"
        axis.plot(generations, group.best.mean, label=f"{label}: fittest", **style)
        axis.plot(generations, group.mean.mean, label=f"{label}: mean", linestyle="--", **style)
    axis.set(xlabel="generation", ylabel="fitness (m)", ylim=(0, None))
    axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    if groups:
        axis.legend(frameon=False)
    return figure


def stick_figures(
    skeletons: Float[np.ndarray, "figure leg joint 3"],
    ground_x: Float[np.ndarray, " node"],
    ground_z: Float[np.ndarray, " node"],
) -> Figure:
    """Returns Figure 5: a planar walker at several times, on its terrain.

    Args:
      skeletons: from `mjxwalk.analysis.sticks.skeleton`, at least one.
      ground_x: where the terrain's nodes are, m.
      ground_z: how high they are, m.

    Raises:
      ValueError: there is no figure to draw.
    """
    if not len(skeletons):
        raise ValueError("there are no stick figures to draw")
    left, right = skeletons[..., 0].min() - 0.2, skeletons[..., 0].max() + 0.2
    low, high = skeletons[..., 2].min() - 0.15, skeletons[..., 2].max() + 0.1
    figure = Figure(figsize=(12, 12 * (high - low) / (right - left)), dpi=120)
    axis: Any = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axis.fill_between(ground_x, ground_z, low, color=GROUND, linewidth=0)
    for skeleton in skeletons:
        for leg in reversed(range(len(skeleton))):  # left and right in turn
            colour = FAR if leg % 2 else NEAR
            axis.plot(*skeleton[leg, :, ::2].T, color=colour, linewidth=2, solid_capstyle="round")
    axis.set(xlim=(left, right), ylim=(low, high), aspect="equal")
    axis.axis("off")
    return figure


def spatial_stick_figures(
    skeletons: Float[np.ndarray, "figure leg joint 3"],
    ground_x: Float[np.ndarray, " node"],
    ground_z: Float[np.ndarray, " node"],
) -> Figure:
    """Returns a spatial walker at several times, from its right side and, below, from the front.

    Args:
      skeletons: from `mjxwalk.analysis.sticks.skeleton`, at least one.
      ground_x: where the nodes of the terrain along its middle are, m.
      ground_z: how high they are, m.

    Raises:
      ValueError: there is no figure to draw.
    """
    if not len(skeletons):
        raise ValueError("there are no stick figures to draw")
    low, high = skeletons[..., 2].min() - 0.1, skeletons[..., 2].max() + 0.1
    # Seen from the front, those in a row stand as far apart as their hips in the side view.
    hips = skeletons[:, :, 1, :2].mean(axis=1)
    across = hips[:, None, None, 0] - (skeletons[..., 1] - hips[:, None, None, 1])
    views = [skeletons[..., 0], across]
    left, right = views[0].min() - 0.3, views[0].max() + 0.3
    height = 12 * 2 * (high - low) / (right - left)
    figure = Figure(figsize=(12, height), dpi=120)
    for row, places in enumerate(views):
        axis: Any = figure.add_axes((0.0, 0.5 * (1 - row), 1.0, 0.5))
        if row == 0:
            axis.fill_between(ground_x, ground_z, low, color=GROUND, linewidth=0)
        for place, skeleton in zip(places, skeletons, strict=True):
            for leg in range(len(skeleton)):  # left and right in turn
                line = place[leg], skeleton[leg, :, 2]
                colour = NEAR if leg % 2 else FAR
                axis.plot(*line, color=colour, linewidth=2, solid_capstyle="round")
        axis.set(xlim=(left, right), ylim=(low, high), aspect="equal")
        axis.axis("off")
    return figure


def angle_densities(density: AngleDensity) -> Figure:
    """Returns Figure 6 or 8: how often each angle is where over a step; white is the most frequent.

    The line is the average course.
    """
    num = len(density.names)
    columns = 2 if num < 9 else 3
    rows = -(-num // columns)
    figure = Figure(figsize=(9, 2.1 * rows), layout="constrained")
    axes: Any = figure.subplots(rows, columns, sharex=True).ravel()
    middles = 100 * (np.arange(density.counts.shape[1]) + 0.5) / density.counts.shape[1]
    shown = zip(axes, density.names, density.edges, density.whiteness, density.mean, strict=False)
    for axis, name, edges, whiteness, mean in shown:
        extent = (0, 100, edges[0], edges[-1])
        axis.imshow(
            whiteness.T, cmap="gray", vmin=0, vmax=1, origin="lower", aspect="auto", extent=extent
        )
        axis.plot(middles, mean, color=MEAN, linewidth=0.8)
        axis.set_title(name, fontsize=10)
        axis.set_ylabel("angle (°)")
        axis.set_ylim(*_occupied(whiteness, edges))
    for axis in axes[num:]:
        axis.axis("off")
    text = f"{density.steps} steps; white: most frequent angle of its slice; line: mean"
    figure.suptitle(text, fontsize=10)
    for axis in axes[num - columns : num]:
        axis.set_xlabel("step (%)")
        axis.tick_params(labelbottom=True)
    return figure


def link_survival(counts: Frame, num_runs: int, bold: Any = None) -> Figure:
    """Returns Table 3 as a picture: in how many runs each link is left.

    Args:
      counts: from `links.survival_table`.
      num_runs: that were counted.
      bold: whether each link is in the reduced set, [network, input]; None for no marks.
    """
    figure = Figure(figsize=(6.5, 6.5), layout="constrained")
    axis: Any = figure.subplots()
    image = axis.imshow(counts.to_numpy() / num_runs, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for (row, column), count in np.ndenumerate(counts.to_numpy()):
        marked = bold is not None and bold[column, row]
        axis.text(
            column,
            row,
            str(count),
            ha="center",
            va="center",
            fontsize=8,
            fontweight="bold" if marked else "normal",
            color="white" if count > 0.6 * num_runs else "black",
        )
    axis.set_xticks(range(counts.shape[1]), counts.columns, rotation=30, ha="right")
    axis.set_yticks(range(counts.shape[0]), counts.index)
    axis.set(xlabel="network", ylabel="input")
    figure.colorbar(image, label=f"share of {num_runs} runs in which the link is left")
    return figure


def _band(axis: Any, x: Any, curve: Curve, colour: str, label: str | None) -> None:
    axis.plot(x, curve.mean, color=colour, linewidth=1.2, label=label)
    axis.fill_between(
        x, curve.mean - curve.sd, curve.mean + curve.sd, color=colour, alpha=0.2, linewidth=0
    )


def _occupied(whiteness: Any, edges: Any) -> tuple[float, float]:
    """Returns the part of an angle's range where walkers are, degrees."""
    there = np.flatnonzero((whiteness > 0.02).any(axis=0))
    if not there.size:
        return float(edges[0]), float(edges[-1])
    margin = 2 * (edges[1] - edges[0])
    low = max(edges[0], edges[there[0]] - margin)
    return float(low), float(min(edges[-1], edges[there[-1] + 1] + margin))
