"""Reads a gait from a user's file: CSV, or OpenSim's .mot and .sto.

A file holds one cycle, heel strike to heel strike of the side that is read, in any number of rows.
In a CSV the first column is `gait_cycle_percent` or `time` (s), and `hip_flexion_deg` and
`knee_flexion_deg` must be there, `ankle_dorsiflexion_deg` may. In a .mot or .sto it is `time`, and
`hip_flexion_r` and `knee_angle_r` must be there, `ankle_angle_r` may, or the same with `_l`; models
whose knees bend to the negative, such as gait2392, are turned around.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.errors import RunError
from mjxwalk.gaits.gait import NUM_POINTS, Gait
from mjxwalk.runs import files

MOST_BYTES = 1 << 24  # ours: of a file; an hour of walking at 1 kHz is not one cycle
FEWEST_ROWS = 20  # ours: fewer do not tell the knee's third harmonic
CSV_COLUMNS = {
    "hip": "hip_flexion_deg",
    "knee": "knee_flexion_deg",
    "ankle": "ankle_dorsiflexion_deg",
}
OPENSIM_COLUMNS = {"hip": "hip_flexion", "knee": "knee_angle", "ankle": "ankle_angle"}
END_OF_HEADER = "endheader"


class _Table(NamedTuple):
    """Numbers by column, and what the file says of their unit."""

    columns: dict[str, Float[np.ndarray, " row"]]
    in_degrees: bool


def read(path: Path, side: Literal["left", "right"] = "right") -> Gait:
    """Returns the gait in a file, as many points as rows have been interpolated to.

    Args:
      path: of a .csv, .mot or .sto file.
      side: whose angles to take where a file has both.

    Raises:
      RunError: the file cannot be read, or is malformed; names the line.
    """
    readers = {".csv": _read_csv, ".mot": _read_opensim, ".sto": _read_opensim}
    if path.suffix.lower() not in readers:
        raise RunError(f"{path} must end in .csv, .mot or .sto to be read as a gait")
    try:
        lines = files.read(path, MOST_BYTES).decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise RunError(f"{path} could not be read: it is no text") from None
    is_csv = path.suffix.lower() == ".csv"
    ending = "" if is_csv else f"_{side[0]}"
    wanted = CSV_COLUMNS if is_csv else OPENSIM_COLUMNS
    names = {joint: name + ending for joint, name in wanted.items()}
    table = readers[path.suffix.lower()](path, lines, (names["hip"], names["knee"]))
    return _gait(path.name, table, names)


def _read_csv(path: Path, lines: Sequence[str], needed: Sequence[str]) -> _Table:
    if not lines:
        raise RunError(f"{path}, line 1: there must be names of columns, got an empty file")
    names = [name.strip() for name in lines[0].split(",")]
    if names[0] not in ("gait_cycle_percent", "time"):
        raise RunError(
            f"{path}, line 1: the first column must be gait_cycle_percent or time, got {names[0]!r}"
        )
    _check_names(path, 1, names, needed)
    return _Table(_numbers(path, names, lines[1:], 2, ","), in_degrees=True)


def _read_opensim(path: Path, lines: Sequence[str], needed: Sequence[str]) -> _Table:
    stripped = [line.strip() for line in lines]
    if END_OF_HEADER not in stripped:
        raise RunError(f"{path}, line {len(lines)}: the file ends without {END_OF_HEADER}")
    end = stripped.index(END_OF_HEADER)
    in_degrees = True
    for number, line in enumerate(stripped[:end], 1):
        name, _, value = line.partition("=")
        if name.strip().lower() == "indegrees":
            if value.strip().lower() not in ("yes", "no"):
                raise RunError(f"{path}, line {number}: inDegrees must be yes or no, got {value!r}")
            in_degrees = value.strip().lower() == "yes"
    first = end + 1
    while first < len(stripped) and not stripped[first]:
        first += 1
    if first == len(stripped):
        raise RunError(f"{path}, line {len(lines)}: the file ends without names of columns")
    names = stripped[first].split()
    if names[0] != "time":
        raise RunError(f"{path}, line {first + 1}: the first column must be time, got {names[0]!r}")
    _check_names(path, first + 1, names, needed)
    return _Table(_numbers(path, names, lines[first + 1 :], first + 2, None), in_degrees)


def _check_names(path: Path, line: int, names: Sequence[str], wanted: Sequence[str]) -> None:
    for name in wanted:
        if name not in names:
            raise RunError(
                f"{path}, line {line}: there is no column {name}, only {', '.join(names)}"
            )


def _numbers(
    path: Path, names: Sequence[str], lines: Sequence[str], first: int, separator: str | None
) -> dict[str, Float[np.ndarray, " row"]]:
    """Returns the columns by name, every cell checked."""
    rows: list[list[float]] = []
    for number, line in enumerate(lines, first):
        if not line.strip():
            continue
        cells = line.split(separator)
        if len(cells) != len(names):
            raise RunError(
                f"{path}, line {number}: there must be {len(names)} numbers, got {len(cells)}"
            )
        row = [_number(path, number, name, cell) for name, cell in zip(names, cells, strict=True)]
        if rows and row[0] <= rows[-1][0]:
            raise RunError(
                f"{path}, line {number}: {names[0]} must be above the {rows[-1][0]:g} of the row "
                f"before, got {row[0]:g}"
            )
        rows.append(row)
    if len(rows) < FEWEST_ROWS:
        raise RunError(
            f"{path}, line {first + len(lines) - 1}: the file ends after {len(rows)} rows of "
            f"numbers; a cycle needs {FEWEST_ROWS}"
        )
    return dict(zip(names, np.array(rows).T, strict=True))


def _number(path: Path, line: int, name: str, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RunError(f"{path}, line {line}: {name} must be a number, got {cell.strip()!r}")
    return value


def _gait(name: str, table: _Table, names: dict[str, str]) -> Gait:
    columns = table.columns
    clock_name, clock = next(iter(columns.items()))
    places = np.linspace(clock[0], clock[-1], NUM_POINTS + 1)[:-1]
    factor = 1.0 if table.in_degrees else 180.0 / math.pi
    curves = {
        joint: factor * np.interp(places, clock, columns[column])
        for joint, column in names.items()
        if column in columns
    }
    if -curves["knee"].min() > curves["knee"].max():
        curves["knee"] = -curves["knee"]
    return Gait(
        name=name,
        hip=curves["hip"],
        knee=curves["knee"],
        ankle=curves.get("ankle"),
        stride_time=float(clock[-1] - clock[0]) if clock_name == "time" else None,
    )
