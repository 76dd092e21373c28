"""Gaits from users' files, and one sentence on each that is malformed."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mjxwalk import gaits
from mjxwalk.errors import RunError

ROWS = 41
HEADER = "Coordinates\nversion=1\nnRows=41\nnColumns=5\ninDegrees={unit}\nendheader\n"
NAMES = "time\thip_flexion_r\thip_flexion_l\tknee_angle_r\tknee_angle_l"


def _hip(share: float) -> float:
    return 10 + 20 * math.cos(2 * math.pi * share)


def _knee(share: float) -> float:
    return 20 - 20 * math.cos(2 * math.pi * share)


def _csv() -> list[str]:
    shares = [row / (ROWS - 1) for row in range(ROWS)]
    rows = [f"{1.2 * share},{_hip(share)},{_knee(share)}" for share in shares]
    return ["time,hip_flexion_deg,knee_flexion_deg", *rows]


def _mot(unit: str = "yes", factor: float = 1.0, knee: float = 1.0) -> list[str]:
    lines = (HEADER.format(unit=unit) + NAMES).split("\n")
    for row in range(ROWS):
        share = row / (ROWS - 1)
        values = (0.5 + 1.1 * share, _hip(share), -5.0, knee * _knee(share), knee * 7.0)
        lines.append("\t".join(str(value * (factor if i else 1)) for i, value in enumerate(values)))
    return lines


def _write(path: Path, lines: list[str]) -> Path:
    path.write_text("\n".join(lines) + "\n")
    return path


def _assert_walks(gait: gaits.Gait) -> None:
    shares = np.arange(gaits.NUM_POINTS) / gaits.NUM_POINTS
    # Between rows 2.5 % apart a straight line is off by up to 20 (2 pi 0.025)^2 / 8 degrees.
    np.testing.assert_allclose(gait.hip, [_hip(share) for share in shares], atol=0.07)
    np.testing.assert_allclose(gait.knee, [_knee(share) for share in shares], atol=0.07)


def test_a_csv_is_read(tmp_path: Path):
    gait = gaits.read(_write(tmp_path / "mine.csv", _csv()))
    _assert_walks(gait)
    assert gait.name == "mine.csv"
    assert gait.stride_time == pytest.approx(1.2)
    assert gait.ankle is None


@pytest.mark.parametrize("ending", ["mot", "sto"])
@pytest.mark.parametrize(
    "lines",
    [_mot(), _mot("no", math.pi / 180), _mot(knee=-1.0)],
    ids=["degrees", "radians", "knees that bend to the negative"],
)
def test_an_opensim_file_is_read(tmp_path: Path, lines: list[str], ending: str):
    gait = gaits.read(_write(tmp_path / f"mine.{ending}", lines))
    _assert_walks(gait)
    assert gait.stride_time == pytest.approx(1.1)


def test_the_other_side_can_be_asked_for(tmp_path: Path):
    gait = gaits.read(_write(tmp_path / "mine.mot", _mot()), side="left")
    np.testing.assert_allclose(gait.hip, -5.0)
    np.testing.assert_allclose(gait.knee, 7.0)


def _cut(lines: list[str]) -> list[str]:
    return lines[:10]


def _without(name: str) -> Callable[[list[str]], list[str]]:
    return lambda lines: [line.replace(name, "other") for line in lines]


def _line(number: int, change: Callable[[str], str]) -> Callable[[list[str]], list[str]]:
    def changed(lines: list[str]) -> list[str]:
        return [change(line) if n == number else line for n, line in enumerate(lines, 1)]

    return changed


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("a.csv", _line(5, lambda line: line + ",3"), "line 5: there must be 3 numbers, got 4"),
        ("a.csv", _line(7, lambda line: "0.2,x,1"), "line 7: hip_flexion_deg .* got 'x'"),
        ("a.csv", _line(9, lambda line: "0.21,nan,1"), "line 9: hip_flexion_deg must be a number"),
        ("a.csv", _line(9, lambda line: "0.0,1,1"), "line 9: time must be above"),
        ("a.csv", _line(1, lambda line: "x" + line), "line 1: the first column must be"),
        ("a.csv", _without("knee_flexion_deg"), "line 1: there is no column knee_flexion_deg"),
        ("a.csv", _cut, "line 10: the file ends after 9 rows"),
        ("a.csv", lambda lines: [], "line 1: .*"),
        ("a.mot", _without("endheader"), "line 48: the file ends without endheader"),
        ("a.mot", _without("hip_flexion_r"), "line 7: there is no column hip_flexion_r"),
        ("a.mot", _line(5, lambda line: "inDegrees=maybe"), "line 5: inDegrees must be yes or no"),
        ("a.mot", _line(7, lambda line: "t" + line), "line 7: the first column must be time"),
        ("a.mot", _line(12, lambda line: line[:-3] + "oops"), "line 12: knee_angle_l must be a"),
        ("a.mot", _line(13, lambda line: line + "\t1"), "line 13: there must be 5 numbers, got 6"),
        ("a.mot", lambda lines: lines[:6], "line 6: the file ends without names of columns"),
        ("a.sto", lambda lines: lines[:7], "line 7: the file ends after 0 rows of numbers"),
        ("a.txt", lambda lines: lines, "must end in .csv, .mot or .sto"),
    ],
)
def test_a_malformed_file_is_refused_in_one_sentence_that_names_the_line(
    tmp_path: Path, name: str, change: Callable[[list[str]], list[str]], message: str
):
    lines = change(_csv() if name.endswith("csv") else _mot())
    path = _write(tmp_path / name, lines)
    with pytest.raises(RunError, match=message) as caught:
        gaits.read(path)
    text = str(caught.value)
    assert text.startswith(str(path))
    assert "\n" not in text


def test_a_file_that_is_missing_or_no_text_is_refused(tmp_path: Path):
    with pytest.raises(RunError, match="no such file"):
        gaits.read(tmp_path / "none.csv")
    (tmp_path / "raw.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(RunError, match="it is no text"):
        gaits.read(tmp_path / "raw.csv")
