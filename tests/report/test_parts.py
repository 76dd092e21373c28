"""Tests of how numbers and tables are written."""

import pytest

from mjxwalk.analysis.paper import LOST, Quoted
from mjxwalk.report import parts
from mjxwalk.report.parts import Cell, Column, Table


@pytest.mark.parametrize("value", [None, float("nan"), float("inf")])
def test_no_number_is_a_dash(value: float | None) -> None:
    assert parts.number(value, 2) == parts.percent(value) == parts.spread(value, 0.1, 2) == "–"


def test_a_deviation_without_value_is_left_out() -> None:
    assert parts.spread(1.234, float("nan"), 2) == "1.23"
    assert parts.spread(1.234, 0.056, 2) == "1.23 ± 0.06"


def test_numbers_of_others_are_lost_or_were_never_given() -> None:
    assert parts.quoted(LOST, 2) == Cell("lost", is_quoted=True)
    assert parts.quoted(None, 2) == Cell("–", is_quoted=True)
    assert parts.quoted(Quoted(0.073, None, ""), 1, scale=100, unit=" %").text == "7.3 %"
    assert parts.quoted(Quoted(1.24, 0.1, ""), 2).text == "1.24 ± 0.10"


def test_neighbouring_columns_share_a_heading() -> None:
    columns = (Column("a"), Column("b", "x"), Column("c", "x"), Column("d"), Column("e", "y"))
    table = Table(name="t", caption="", head="", columns=columns, groups=(), data=None)
    assert [(span.title, [c.title for c in span.columns]) for span in table.spans] == [
        ("", ["a"]),
        ("x", ["b", "c"]),
        ("", ["d"]),
        ("y", ["e"]),
    ]
