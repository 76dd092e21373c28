"""Tests of files that the user names: links are followed, and nothing is made another kind."""

import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from mjxwalk import outputs
from mjxwalk.cli import main
from mjxwalk.errors import RunError
from mjxwalk.runs import files


def contents(path: Path) -> list[str]:
    return sorted(each.name for each in path.iterdir())


def test_a_link_stays_and_what_it_leads_to_is_replaced_with_its_mode(tmp_path: Path) -> None:
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_text("old and longer")
    target.chmod(0o640)
    link.symlink_to("target")
    before = target.stat().st_ino
    outputs.write(link, b"new")
    assert link.is_symlink()
    assert target.read_bytes() == b"new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o640
    assert target.stat().st_ino != before, "not replaced whole"
    assert contents(tmp_path) == ["link", "target"]


def test_a_link_to_nothing_makes_what_it_leads_to(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to("there/new")
    outputs.check(tmp_path / "link")
    outputs.write(tmp_path / "link", b"new")
    assert (tmp_path / "there" / "new").read_bytes() == b"new"
    assert (tmp_path / "link").is_symlink()


def test_a_pipe_stays_a_pipe_and_gets_the_content(tmp_path: Path) -> None:
    pipe, read = tmp_path / "pipe", list[bytes]()
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    outputs.check(pipe)
    outputs.write(pipe, b"content")
    reader.join(10)
    assert read == [b"content"]
    assert stat.S_ISFIFO(pipe.stat().st_mode)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root makes devices")
@pytest.mark.parametrize("way", ["device", "link"])
def test_a_device_stays_a_device(tmp_path: Path, way: str) -> None:
    device = tmp_path / "device"
    try:
        os.mknod(device, stat.S_IFCHR | 0o666, os.makedev(1, 3))  # as /dev/null is
        device.write_bytes(b"")
    except OSError as error:
        pytest.skip(f"no devices here: {error}")
    (tmp_path / "link").symlink_to(device)
    outputs.check(tmp_path / way)
    outputs.write(tmp_path / way, b"content")
    assert stat.S_ISCHR(device.stat().st_mode)
    assert contents(tmp_path) == ["device", "link"]


def test_a_file_with_a_second_name_changes_under_both(tmp_path: Path) -> None:
    (tmp_path / "one").write_text("old and longer")
    os.link(tmp_path / "one", tmp_path / "two")
    outputs.write(tmp_path / "one", b"new")
    assert (tmp_path / "two").read_bytes() == b"new"


def test_a_new_file_gets_the_usual_mode(tmp_path: Path) -> None:
    mask = os.umask(0o027)
    try:
        outputs.write(tmp_path / "new", b"")
    finally:
        os.umask(mask)
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o640


@pytest.mark.parametrize("name", ["/dev/stdout", "log", "/proc/self/fd/1"])
def test_standard_output_is_added_to_where_it_stands(tmp_path: Path, name: str) -> None:
    code = f"""
from pathlib import Path
from mjxwalk import outputs
print("before")
outputs.write(Path({name!r}), b"content\\n")
outputs.tell(Path({name!r}))
print("after")
"""
    with (tmp_path / "log").open("wb") as log:
        subprocess.run([sys.executable, "-c", code], stdout=log, check=True, cwd=tmp_path)
    assert (tmp_path / "log").read_text() == "before\ncontent\nafter\n"


def test_what_cannot_be_written_is_told_before_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    for name, reason in (
        ("folder", "is a folder; name a file in it"),
        ("no/file", "is in no folder that is there"),
        ("loop", "too many levels"),
        ("x" * 300, "file name too long"),
    ):
        with pytest.raises(RunError, match=reason):
            outputs.check(tmp_path / name)
        with pytest.raises(RunError, match="could not be written"):
            outputs.write(tmp_path / name, b"")
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(RunError, match="--json .* cannot be written: permission denied"):
        outputs.check(tmp_path / "file", "--json")
    assert contents(tmp_path) == ["folder", "loop"]


def test_a_file_whose_folder_takes_no_other_is_written_in_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("old and longer")

    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    outputs.write(tmp_path / "file", b"new")
    assert (tmp_path / "file").read_bytes() == b"new"
    assert contents(tmp_path) == ["file"]


def test_a_failed_write_leaves_the_old_content(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("old")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(RunError, match="could not be written: no space left on device"):
        outputs.write(tmp_path / "file", b"new")
    assert (tmp_path / "file").read_text() == "old"
    assert contents(tmp_path) == ["file"]


def test_a_figure_goes_where_it_is_named_whatever_that_is_called(tmp_path: Path) -> None:
    from matplotlib.figure import Figure

    for name, start in (("a.png", b"\x89PNG"), ("no-ending", b"\x89PNG"), ("a.svg", b"<?xml")):
        outputs.write_figure(tmp_path / name, Figure(figsize=(1, 1)))
        assert (tmp_path / name).read_bytes().startswith(start)
    with pytest.raises(RunError, match="a.xyz could not be written: Format 'xyz'"):
        outputs.write_figure(tmp_path / "a.xyz", Figure(figsize=(1, 1)))
    assert contents(tmp_path) == ["a.png", "a.svg", "no-ending"]


def test_export_writes_a_body_through_a_link_and_a_controller_into_a_pipe(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    link, pipe, read = tmp_path / "link.xml", tmp_path / "pipe", list[bytes]()
    link.symlink_to("body.xml")
    assert main(["export", "zoo:planar-lpd", "--to", "mjcf", "--out", str(link)]) == 0
    assert link.is_symlink() and (tmp_path / "body.xml").read_bytes().startswith(b"<mujoco")
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    assert main(["export", "zoo:planar-lpd", "--to", "npz", "--out", str(pipe)]) == 0
    reader.join(10)
    assert read and read[0].startswith(b"PK")
    assert contents(tmp_path) == ["body.xml", "link.xml", "pipe"], "a file beside a pipe"


def test_files_that_are_named_may_be_read_through_links_but_block_nothing(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("content")
    (tmp_path / "link").symlink_to("a")
    os.mkfifo(tmp_path / "pipe")
    assert files.read(tmp_path / "link") == b"content"
    with pytest.raises(RunError, match="it is no plain file"):
        files.read(tmp_path / "pipe")
