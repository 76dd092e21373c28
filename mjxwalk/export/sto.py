"""Tables over time as OpenSim's .sto, and as CSV."""

import csv
import io
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.errors import RunError
from mjxwalk.runs import files

END = "endheader"


class Table(NamedTuple):
    """Columns over time.

    Attributes:
      title: of the table, a line.
      notes: further lines.
      names: of the columns, "time" first.
      rows: numbers; angles in rad.
    """

    title: str
    notes: tuple[str, ...]
    names: tuple[str, ...]
    rows: Float[np.ndarray, "row column"]


def as_sto(table: Table) -> bytes:
    """Returns an OpenSim storage file; every number reads back as it was."""
    head = [
        table.title,
        "version=1",
        f"nRows={len(table.rows)}",
        f"nColumns={len(table.names)}",
        "inDegrees=no",
        *table.notes,
        END,
        "\t".join(table.names),
    ]
    return "\n".join([*head, *("\t".join(_words(row)) for row in table.rows), ""]).encode()


def as_csv(table: Table) -> bytes:
    """Returns a CSV file with a line of names; every number reads back as it was."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table.names)
    writer.writerows(_words(row) for row in table.rows)
    return text.getvalue().encode()


def read_sto(path: Path) -> Table:
    """Returns the table of an OpenSim storage file, its numbers as they are written.

    Raises:
      RunError: the file cannot be read, or is none.
    """
    lines = files.read(path).decode(errors="replace").splitlines()
    if END not in (stripped := [line.strip() for line in lines]):
        raise RunError(f"{path} is no .sto file: it has no line {END}")
    end = stripped.index(END)
    title, *notes = stripped[:end] or [""]
    settings = dict(note.split("=", 1) for note in notes if "=" in note)
    names = tuple(stripped[end + 1].split("\t")) if end + 1 < len(lines) else ()
    try:
        rows = [[float(word) for word in line.split()] for line in stripped[end + 2 :] if line]
        table = np.array(rows, np.float64).reshape(len(rows), len(names))
    except ValueError as error:
        raise RunError(f"{path} holds a line that is no row of its table: {error}") from None
    for name, found in (("nRows", len(rows)), ("nColumns", len(names))):
        if settings.get(name, str(found)) != str(found):
            raise RunError(f"{path} says {name}={settings[name]} but holds {found}")
    return Table(title, tuple(note for note in notes if "=" not in note), names, table)


def _words(row: Float[np.ndarray, " column"]) -> list[str]:
    return [repr(float(value)) for value in row]
