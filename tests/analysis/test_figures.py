"""Tests of the figures: that they hold the numbers they were given, and can be written."""

import io
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from mjxwalk.analysis import curves, figures, links
from mjxwalk.analysis.angles import add_steps, empty_density
from mjxwalk.analysis.curves import PhaseCurves
from mjxwalk.controllers.linear_reactive import ANGLES, local_links


def written(figure: Figure) -> bytes:
    file = io.BytesIO()
    figure.savefig(file, format="png")
    return file.getvalue()


def phase(name: str, generations: int, runs: int = 3) -> PhaseCurves:
    best = np.arange(1.0, generations + 1)
    made = [{"best_fitness": best + run, "mean_fitness": 0.5 * best} for run in range(runs)]
    return curves.average_phase(name, made)


def test_figure_4a_puts_phases_one_after_the_other() -> None:
    figure = figures.fitness_over_phases([phase("lpd", 5), phase("fil", 20), phase("none", 0)])
    assert written(figure).startswith(b"\x89PNG")
    axis: Any = figure.axes[0]
    first, _, second, _ = (line for line in axis.lines if len(line.get_xdata()) > 2)
    np.testing.assert_allclose(first.get_xdata(), [1, 2, 3, 4, 5])
    np.testing.assert_allclose(first.get_ydata(), np.arange(1.0, 6.0) + 1.0)
    np.testing.assert_allclose(second.get_xdata(), np.arange(6, 26))
    assert [text.get_text() for text in axis.texts] == ["lpd\n3 runs", "fil\n3 runs"]


@pytest.mark.parametrize("runs", [0, 1])
def test_figure_4_can_be_drawn_of_few_runs(runs: int) -> None:
    phases = [phase("lpd", 4, runs)]
    assert written(figures.fitness_over_phases(phases))
    assert written(figures.fitness_of_groups(phases[:runs]))


def test_figure_4b_draws_the_first_group_thick() -> None:
    figure = figures.fitness_of_groups([phase("RSIL", 5), phase("FIL", 5)])
    widths = [line.get_linewidth() for line in figure.axes[0].lines]
    assert widths[0] == widths[1] > widths[2] == widths[3]
    assert written(figure)


def test_figure_5_shows_every_figure_with_both_legs() -> None:
    skeletons = np.random.default_rng(0).random((4, 2, 8, 3))
    figure = figures.stick_figures(skeletons, np.linspace(-1, 2, 5), np.zeros(5))
    assert len(figure.axes[0].lines) == 8
    assert written(figure)
    with pytest.raises(ValueError, match="no stick figures"):
        figures.stick_figures(skeletons[:0], np.zeros(2), np.zeros(2))


def test_figure_6_shows_all_seven_angles() -> None:
    draws = np.random.default_rng(0).normal(0.0, 5.0, (50, 10, 7))
    density = add_steps(empty_density(slices=10, bins=20), draws)
    figure = figures.angle_densities(density)
    titles = [axis.get_title() for axis in figure.axes if axis.images]
    assert titles == list(ANGLES)
    shown = np.asarray(figure.axes[0].images[0].get_array())
    np.testing.assert_allclose(shown, density.whiteness[0].T)
    assert written(figure) and written(figures.angle_densities(empty_density()))


def test_table_3_as_a_picture_shows_every_count() -> None:
    present = np.stack([local_links(), np.ones((6, 16), bool)])
    figure = figures.link_survival(links.survival_table(present), 2, local_links())
    assert sorted({text.get_text() for text in figure.axes[0].texts}) == ["1", "2"]
    bold = [text for text in figure.axes[0].texts if text.get_fontweight() == "bold"]
    assert len(bold) == local_links().sum()
    assert written(figure)
