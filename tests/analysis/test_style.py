"""Tests that figures look the same whatever the user has set up for figures of their own."""

import io

import matplotlib
from matplotlib.figure import Figure

from mjxwalk.analysis import style


@style.own()
def drawn() -> bytes:
    figure = Figure()
    figure.subplots().plot([0.0, 0.5, 1.5], [1.5, 2.25, 0.0])
    content = io.BytesIO()
    figure.savefig(content, format="png")
    return content.getvalue()


def test_a_style_of_the_users_changes_no_figure() -> None:
    usual = drawn()
    with matplotlib.rc_context({"lines.linewidth": 9.0, "axes.facecolor": "black"}):
        assert drawn() == usual
        assert matplotlib.rcParams["lines.linewidth"] == 9.0
