"""Files of this user's own count for nothing where somebody else could have written them."""

import os
from pathlib import Path

import pytest

from mjxwalk import data_folder

pytestmark = pytest.mark.skipif(os.name == "nt", reason="rights of Windows are those of folders")


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Returns the folder."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return tmp_path / "data" / "mjxwalk"


def test_lines_come_back_by_their_first_words(place: Path) -> None:
    data_folder.append("names", "one 1")
    data_folder.append("names", "two")
    assert data_folder.lines("names") == {"one", "two"}
    assert data_folder.lines("others") == set()
    assert place.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_a_file_that_others_can_write_is_not_read_nor_mended(place: Path, mode: int) -> None:
    data_folder.append("names", "one")
    (place / "names").chmod(mode)
    assert data_folder.lines("names") == set()
    data_folder.append("names", "two")
    assert data_folder.lines("names") == set()


def test_a_link_in_the_place_of_the_file_is_not_followed(place: Path, tmp_path: Path) -> None:
    (tmp_path / "elsewhere").write_text("evil\n")
    data_folder.append("names", "one")
    (place / "names").unlink()
    (place / "names").symlink_to(tmp_path / "elsewhere")
    assert data_folder.lines("names") == set()
    data_folder.append("names", "two")
    assert (tmp_path / "elsewhere").read_text() == "evil\n"


def test_a_folder_that_others_can_write_is_not_used(place: Path) -> None:
    data_folder.append("names", "one")
    place.chmod(0o777)
    assert data_folder.lines("names") == set()


def test_a_pipe_in_its_place_is_not_waited_for(place: Path) -> None:
    data_folder.append("names", "one")
    (place / "names").unlink()
    os.mkfifo(place / "names", 0o600)
    assert data_folder.lines("names") == set()
