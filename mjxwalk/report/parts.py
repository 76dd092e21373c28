"""What a page is made of, and how its numbers are written."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

from markupsafe import Markup

from mjxwalk.analysis.frame import Frame
from mjxwalk.analysis.paper import Quoted

NOTHING = "–"
LOST = "lost"  # of a number that the paper had


class Cell(NamedTuple):
    """One place of a table.

    Attributes:
      text: what stands there.
      is_quoted: whether it is another's number and not ours.
      share: between 0 and 1, shown as a tint; None for none.
      is_marked: whether it stands out.
    """

    text: str
    is_quoted: bool = False
    share: float | None = None
    is_marked: bool = False


class Row(NamedTuple):
    """A row of a table: what it is about, and its cells."""

    head: str
    cells: tuple[Cell, ...]


class RowGroup(NamedTuple):
    """Rows that belong together, under a heading or ""."""

    title: str
    rows: tuple[Row, ...]


class Column(NamedTuple):
    """A column, alone or under a heading that it shares with its neighbours."""

    title: str
    group: str = ""


class Span(NamedTuple):
    """A heading over neighbouring columns; one without a title stands for one column."""

    title: str
    columns: tuple[Column, ...]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Table:
    """A table, and the file of its plain numbers.

    Attributes:
      name: of the file, without its ending.
      caption: what it shows.
      head: over the first column.
      columns: the others.
      groups: of rows.
      data: the numbers that are written beside the page.
      note: how to read it.
    """

    name: str
    caption: str
    head: str
    columns: tuple[Column, ...]
    groups: tuple[RowGroup, ...]
    data: Frame
    note: str = ""

    @property
    def spans(self) -> list[Span]:
        """The headings over the columns, left to right."""
        found: list[Span] = []
        for column in self.columns:
            if column.group and found and found[-1].title == column.group:
                found[-1] = Span(column.group, (*found[-1].columns, column))
            else:
                found.append(Span(column.group, (column,)))
        return found


@dataclasses.dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure, and the file of its plain numbers.

    Attributes:
      name: of the file, without its ending.
      caption: what it shows.
      svg: the drawing, with what there is to see for those who cannot.
      data: the numbers that are written beside the page; None for none.
    """

    name: str
    caption: str
    svg: Markup
    data: Frame | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Replay:
    """A walker that walks, drawn by the program of `mjxwalk watch`.

    Attributes:
      name: of it, which no other part has.
      show: what is shown, as JSON that no text can break out of.
      series: its numbers, as base64 text.
      why: the trial ended, for those who cannot see it or print it.
      data: nothing is written beside the page.
    """

    name: str
    show: Markup
    series: str
    why: str
    data: Frame | None = None


Part: TypeAlias = Table | Picture | Replay


@dataclasses.dataclass(frozen=True, kw_only=True)
class Section:
    """A heading and what is under it.

    Attributes:
      anchor: its name in addresses.
      title: its heading.
      texts: paragraphs, first of all.
      commands: to type, after the paragraphs.
      parts: tables, pictures and replays.
    """

    anchor: str
    title: str
    texts: tuple[str, ...] = ()
    commands: tuple[str, ...] = ()
    parts: tuple[Part, ...] = ()


class Remark(NamedTuple):
    """What a reader has to know before believing a number.

    Attributes:
      text: a sentence.
      items: what it is true of, and what to type about it or "".
    """

    text: str
    items: tuple[tuple[str, str], ...] = ()


@dataclasses.dataclass(frozen=True, kw_only=True)
class Page:
    """All of a report.

    Attributes:
      title: of the page.
      lead: what was run and what came out, in a few sentences.
      remarks: what to know before.
      sections: in their order.
      references: where numbers of others are from.
    """

    title: str
    lead: tuple[str, ...]
    remarks: tuple[Remark, ...]
    sections: tuple[Section, ...]
    references: tuple[str, ...] = ()

    @property
    def moves(self) -> bool:
        """Whether there is a replay."""
        return any(isinstance(part, Replay) for part in self.parts)

    @property
    def parts(self) -> list[Part]:
        """All tables, pictures and replays."""
        return [part for section in self.sections for part in section.parts]


def number(value: float | None, places: int) -> str:
    """Returns a number as text; a dash for none, NaN or infinite."""
    if value is None or not math.isfinite(value):
        return NOTHING
    return f"{value:,.{places}f}"


def percent(share: float | None, places: int = 1) -> str:
    """Returns a share as text."""
    text = number(None if share is None else 100 * share, places)
    return text if text == NOTHING else f"{text} %"


def spread(mean: float | None, sd: float | None, places: int) -> str:
    """Returns a mean with its deviation, where there is one."""
    first, second = number(mean, places), number(sd, places)
    return first if NOTHING in (first, second) else f"{first} ± {second}"


def quoted(value: Quoted | None, places: int, *, scale: int = 1, unit: str = "") -> Cell:
    """Returns another's number: a dash for one that nobody ever gave, "lost" for one that is."""
    if value is None:
        return Cell(NOTHING, is_quoted=True)
    if value.value is None:
        return Cell(LOST, is_quoted=True)
    sd = None if value.sd is None else scale * value.sd
    return Cell(spread(float(scale * value.value), sd, places) + unit, is_quoted=True)


def cells(*texts: str) -> tuple[Cell, ...]:
    """Returns plain cells."""
    return tuple(Cell(text) for text in texts)


def frame(rows: Sequence[dict[str, Any]]) -> Frame:
    """Returns a table of plain numbers, a row each."""
    import pandas as pd

    return pd.DataFrame(list(rows))


def count(num: int, word: str) -> str:
    """Returns a number with its noun, such as "1 run" and "3 runs"."""
    return f"{num:,} {word}{'' if num == 1 else 's'}"
