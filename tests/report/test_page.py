"""Tests of the page itself, by the standard library's HTML parser."""

import re
from pathlib import Path

import pandas as pd
import pytest
from matplotlib.figure import Figure
from report.outline import Outline

from mjxwalk.errors import RunError
from mjxwalk.report import drawing, page
from mjxwalk.report.parts import (
    Cell,
    Column,
    Page,
    Picture,
    Remark,
    Row,
    RowGroup,
    Section,
    Table,
)

EVIL = '"><script>alert(1)</script><img src=x onerror=alert(1)>'


def picture() -> Picture:
    figure = Figure(figsize=(3, 2))
    figure.subplots().plot([0, 1])
    svg = drawing.inline(figure, name="figure-1", alt=EVIL)
    return Picture(name="figure-1", caption=EVIL, svg=svg)


def table() -> Table:
    row = Row(EVIL, (Cell(EVIL), Cell("lost", is_quoted=True), Cell("3", share=0.5)))
    return Table(
        name="table-1",
        caption=EVIL,
        head="of",
        columns=(Column("a"), Column("b", "x"), Column("c", "x")),
        groups=(RowGroup(EVIL, (row,)),),
        data=pd.DataFrame({"a": [0.1], "b": [EVIL]}),
        note=EVIL,
    )


def whole() -> Page:
    section = Section(
        anchor="one", title=EVIL, texts=(EVIL,), commands=(EVIL,), parts=(table(), picture())
    )
    return Page(
        title=EVIL,
        lead=(EVIL,),
        remarks=(Remark(EVIL, ((EVIL, EVIL),)),),
        sections=(section,),
        references=(EVIL,),
    )


def test_what_texts_hold_is_read_and_never_obeyed() -> None:
    outline = Outline(page.render(whole()))
    assert not outline.unbalanced
    assert not outline.named("script", "img", "iframe", "object", "link", "form")
    assert not [n for e in outline.elements for n in e.attributes if n.startswith("on")]
    assert outline.text.count(EVIL) >= 11
    policy = outline.named("meta")[3].attributes["content"]
    assert policy.startswith("default-src 'none'; ") and "script" not in policy


def test_the_page_needs_nothing_but_itself() -> None:
    html = page.render(whole())
    assert "url(http" not in html and "@import" not in html
    outline = Outline(html)
    assert not [
        value for value in outline.values("src") + outline.values("xlink:href") if "//" in value
    ]
    links = [e.attributes["href"] for e in outline.named("a")]
    assert set(links) == {"#remarks", "#one", "table-1.csv"}


def test_headings_tables_and_figures_can_be_heard() -> None:
    outline = Outline(page.render(whole()))
    assert [e.tag for e in outline.named("h1", "h2", "h3")] == ["h1", "h2", "h2"]
    assert outline.named("html")[0].attributes["lang"] == "en"
    ids = outline.values("id")
    assert len(ids) == len(set(ids))
    assert set(outline.values("aria-labelledby")) <= set(ids)
    assert all("scope" in e.attributes for e in outline.named("th"))
    assert len(outline.named("caption")) == len(outline.named("table")) == 1
    assert len(outline.named("figcaption")) == len(outline.named("figure")) == 1
    (svg,) = outline.named("svg")
    assert (svg.attributes["role"], svg.attributes["aria-label"]) == ("img", EVIL)
    # What scrolls sideways can be scrolled by keyboard.
    wide = [e for e in outline.elements if e.attributes.get("class") == "wide"]
    assert [e.attributes["tabindex"] for e in wide] == ["0", "0"]


def test_every_row_is_as_wide_as_the_head() -> None:
    outline = Outline(page.render(whole()))
    spans = [int(v) for v in outline.values("colspan")]
    assert spans == [2, 4]
    assert len(outline.named("td")) == 3


def luminance(colour: str) -> float:
    """As the Web Content Accessibility Guidelines 2.2 define it."""
    parts = [int(colour[place : place + 2], 16) / 255 for place in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_letters_stand_out_from_their_ground_in_the_light_and_in_the_dark() -> None:
    css = Path(page.__file__).with_name("page.css").read_text()
    light, dark = (
        dict(re.findall(r"--([\w-]+): (#\w{6})", part)) for part in css.split("@media")[:2]
    )
    for colours in (light, {**light, **dark}):
        for letters in ("ink", "muted", "link"):
            for ground in ("paper", "raised"):
                pair = sorted(luminance(colours[name]) for name in (letters, ground))
                # Level AA of the same guidelines.
                assert (pair[1] + 0.05) / (pair[0] + 0.05) >= 4.5


def test_numbers_lie_beside_the_page(tmp_path: Path) -> None:
    paths = page.write(tmp_path, whole())
    assert [path.name for path in paths] == ["report.html", "table-1.csv"]
    assert sorted(paths) == sorted(tmp_path.iterdir())
    read = pd.read_csv(tmp_path / "table-1.csv")
    assert read.to_dict("records") == [{"a": 0.1, "b": EVIL}]


def test_a_folder_that_cannot_be_made_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(RunError, match="file could not be made: file exists"):
        page.prepare(tmp_path / "file")
