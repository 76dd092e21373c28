"""Tests of OpenSim's storage files: what is none is refused."""

from pathlib import Path

import pytest

from mjxwalk.errors import RunError
from mjxwalk.export import sto


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ("no header", "it has no line endheader"),
        ("a\nnRows=2\nendheader\ntime\n1\n", "says nRows=2 but holds 1"),
        ("a\nendheader\ntime\tx\n1\t2\n3\n", "no row of its table"),
        ("a\nendheader\ntime\nx\n", "no row of its table"),
    ],
)
def test_what_is_no_sto_is_one_sentence(content: str, complaint: str, tmp_path: Path) -> None:
    path = tmp_path / "x.sto"
    path.write_text(content)
    with pytest.raises(RunError, match=complaint):
        sto.read_sto(path)
