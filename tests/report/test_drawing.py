"""Tests of figures as parts of a page."""

import re

from matplotlib.figure import Figure
from report.outline import Outline

from mjxwalk.analysis import figures
from mjxwalk.report import drawing


def draw(colour: str = figures.NEAR) -> Figure:
    figure = Figure(figsize=(3, 2))
    axis = figure.subplots()
    axis.plot([0, 1, 2], [0, 1, 0.123456], color=colour, label="fittest")
    axis.imshow([[0.0, 1.0]], cmap="gray", extent=(0, 2, 0, 1))
    axis.set_xlabel("generation")
    return figure


def test_colours_are_the_pages_own() -> None:
    svg = drawing.inline(draw(), name="a", alt="")
    assert f"stroke: var(--near, {figures.NEAR})" in svg
    assert "stroke: currentColor" in svg
    assert "#000000" not in svg


def test_letters_stay_letters() -> None:
    assert "generation" in Outline(drawing.inline(draw(), name="a", alt="")).text


def test_a_drawing_has_names_of_its_own_for_what_it_refers_to() -> None:
    names: list[set[str]] = []
    for name in ("a", "b"):
        svg = drawing.inline(draw(), name=name, alt="")
        used = set(re.findall(r'xlink:href="#([^"]+)|url\(#([^)]+)', svg))
        assert {one or other for one, other in used} == set(Outline(svg).values("id"))
        names.append(set(Outline(svg).values("id")))
    assert names[0] and names[1] and not names[0] & names[1]


def test_alternative_text_cannot_end_its_attribute() -> None:
    alt = '"><script>alert(1)</script>'
    outline = Outline(drawing.inline(draw(), name="a", alt=alt))
    assert outline.named("svg")[0].attributes["aria-label"] == alt
    assert not outline.named("script")


def test_a_drawing_is_the_same_twice_and_fetches_nothing() -> None:
    svg = drawing.inline(draw(), name="a", alt="")
    assert svg == drawing.inline(draw(), name="a", alt="")
    links = Outline(svg).values("xlink:href")
    assert all(link.startswith(("#", "data:image/png;base64,")) for link in links)
