"""Tests of what looks on while a run goes on: its page on localhost, and TensorBoard."""

import contextlib
import os
import re
import socket
import struct
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
import toy
from player import given

from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.player import bodies, recording
from mjxwalk.player.recording import Ground, Show, Take
from mjxwalk.player.shown_walkers import ShownWalkers
from mjxwalk.runs import Metrics
from mjxwalk.watch import live, serving, tensorboard
from mjxwalk.watch.serving import Serving


class Said:
    """A progress that keeps what it is told."""

    def __init__(self) -> None:
        self.told: list[str] = []

    def start(self, *_: Any) -> None:
        self.told.append("start")

    def generation(self, line: Metrics) -> None:
        self.told.append(f"generation {line.generation}")

    def say(self, text: str) -> None:
        self.told.append(text)

    def close(self) -> None:
        self.told.append("close")

    def finish(self, *_: Any) -> None:
        self.told.append("finish")


def line(generation: int) -> Metrics:
    figures: dict[str, Any] = dict.fromkeys(Metrics.__struct_fields__, 0.5)
    figures.update(generation=generation, speed_m_s=None, physics_steps=7)
    figures.update(strategy={"sigma": 0.25, "none": None})
    return Metrics(**figures)


def get(address: str) -> tuple[int, bytes]:
    with urllib.request.urlopen(address, timeout=30) as answer:
        return answer.status, answer.read()


def nothing_walks(shown: ShownWalkers, take: Take) -> tuple[Show, str]:
    """Stands for the recording, which other tests are of."""
    del take
    ground = Ground(x=0.0, y=0.0, spacing=0.1, rows=1, width=1.0)
    body = bodies.describe(shown.experiment.env)
    show = Show(
        title=shown.source,
        what=shown.what,
        facts=(),
        frame_s=0.02,
        weight_n=1.0,
        body=body,
        ground=ground,
        walkers=(),
        series={},
    )
    return show, ""


def test_the_newest_walker_is_served_on_localhost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recording, "perform", nothing_walks)
    run = tmp_path / "run"
    given.make_run(run)
    inner = Said()
    shown = live.Live(inner, port=0)
    shown.start(run, run_config.read(run), None)
    assert inner.told == ["start", f"watch it walk: {shown.address}"]
    assert b"first generation is not there yet" in get(shown.address)[1]
    assert get(f"{shown.address}news?after=-1") == (204, b"")
    shown.generation(line(5))
    until = time.monotonic() + 120
    while shown.newest() is None and time.monotonic() < until:
        time.sleep(0.1)
    status, news = get(f"{shown.address}news?after=-1")
    told = msgspec.json.decode(news)
    assert status == 200 and told["number"] == 0
    assert told["show"]["what"] == "fittest so far, generation 5"
    assert get(f"{shown.address}news?after=0") == (204, b"")
    text = get(shown.address)[1].decode()
    assert 'data-live="0"' in text and "connect-src" in text
    with pytest.raises(urllib.error.HTTPError, match="404"):
        get(f"{shown.address}etc/passwd")
    shown.close()
    assert inner.told[-2:] == ["generation 5", "close"]


def ask(server: Serving, *lines: str) -> bytes:
    """Returns the answer to a request, as it comes."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=30) as connection:
        head = "".join(f"{line.format(port=server.port)}\r\n" for line in lines)
        connection.sendall(f"{head}Connection: close\r\n\r\n".encode("latin-1"))
        answer = b""
        with contextlib.suppress(ConnectionError):  # closed before it had read all
            while more := connection.recv(1 << 16):
                answer += more
        return answer


@pytest.fixture
def server() -> Iterator[Serving]:
    found = Serving(live.Live(Said()).find, 0)
    yield found
    found.close()


def test_a_port_that_is_taken_is_another(server: Serving) -> None:
    second = Serving(live.Live(Said()).find, server.port)
    assert second.port != server.port
    second.close()


@pytest.mark.parametrize("host", ["localhost:{port}", "127.0.0.1:{port}", "[::1]:{port}"])
def test_this_machine_is_answered_by_any_of_its_names(server: Serving, host: str) -> None:
    assert ask(server, "GET / HTTP/1.1", f"Host: {host}").startswith(b"HTTP/1.1 200 OK")


@pytest.mark.parametrize(
    "lines",
    [
        ("GET / HTTP/1.1", "Host: evil.example:{port}"),
        ("GET / HTTP/1.1", "Host: localhost"),
        ("GET / HTTP/1.1", "Host: localhost:1"),
        ("GET /news?after=-1 HTTP/1.1", "Host: localhost.evil.example:{port}"),
        ("GET / HTTP/1.0",),
        ("POST / HTTP/1.1", "Host: localhost:{port}"),
        ("GET /../../etc/passwd HTTP/1.1", "Host: localhost:{port}"),
        ("GET /news?after=\xb2 HTTP/1.1", "Host: localhost:{port}"),
        ("GET /news?after=" + "9" * 5000 + " HTTP/1.1", "Host: localhost:{port}"),
        ("GET /%ff%00 HTTP/1.1", "Host: localhost:{port}"),
        ("GET / HTTP/1.1", "Host: localhost:{port}", "X: " + "a" * 100_000),
        ("\xff\x00\x01",),
        ("",),
    ],
)
def test_what_no_browser_here_asks_for_is_not_answered(
    server: Serving, lines: tuple[str, ...], capfd: pytest.CaptureFixture[str]
) -> None:
    answer = ask(server, *lines)
    assert not answer or re.match(rb"HTTP/1.[01] 4\d\d ", answer), answer[:100]
    assert b"mjxwalk" not in answer
    assert ask(server, "GET / HTTP/1.1", "Host: localhost:{port}").startswith(b"HTTP/1.1 200 OK")
    assert capfd.readouterr() == ("", "")


def test_open_connections_leave_the_run_its_files_and_are_closed_in_time(
    server: Serving, capfd: pytest.CaptureFixture[str]
) -> None:
    silent = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(150)]
    time.sleep(1.0)
    descriptors = len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").exists() else 0
    assert descriptors < 150 + serving.CONNECTIONS + 50
    for each in silent[:50]:  # those that go before they are answered
        each.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
        each.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        each.close()
    silent[60].settimeout(60.0)
    assert silent[60].recv(1) == b""  # closed by the server
    assert ask(server, "GET / HTTP/1.1", "Host: localhost:{port}").startswith(b"HTTP/1.1 200 OK")
    for each in silent[50:]:
        each.close()
    assert capfd.readouterr() == ("", "")


def test_a_page_that_cannot_be_served_or_drawn_leaves_the_run_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: Any) -> Any:
        raise ValueError("no such thing\nas a walker")

    given.make_run(tmp_path / "run")
    monkeypatch.setattr(recording, "perform", fails)
    inner = Said()
    shown = live.Live(inner, port=0)
    shown.start(tmp_path / "run", run_config.read(tmp_path / "run"), None)
    shown.generation(line(5))
    until = time.monotonic() + 60
    while len(inner.told) < 4 and time.monotonic() < until:
        time.sleep(0.1)
    assert inner.told[-1] == "the page shows no newer walker (no such thing)"
    shown.generation(line(6))
    shown.close()
    assert inner.told[-2:] == ["generation 6", "close"]

    def refuses(*_: Any, **__: Any) -> Any:
        raise OSError(24, "Too many open files")

    monkeypatch.setattr(serving, "create_server", refuses)
    inner = Said()
    shown = live.Live(inner, port=0)
    shown.start(tmp_path / "run", run_config.read(tmp_path / "run"), None)
    shown.generation(line(5))
    shown.close()
    assert inner.told[1] == (
        "no page can be served on localhost (Too many open files); the run goes on without it"
    )
    assert inner.told[-2:] == ["generation 5", "close"]


def test_figures_without_a_value_are_left_out() -> None:
    found = tensorboard.scalars(line(3))
    assert found["best_fitness"] == 0.5 and found["strategy/sigma"] == 0.25
    assert not {"generation", "speed_m_s", "strategy/none", "strategy"} & set(found)


def test_tensorboard_reads_every_generation(tmp_path: Path) -> None:
    events: Any = pytest.importorskip("tensorboardX.proto.event_pb2")
    inner = Said()
    shown = tensorboard.TensorBoard(inner)
    shown.start(tmp_path, Config(experiment=toy.Toy(), seed=0), None)
    for generation in (1, 2):
        shown.generation(line(generation))
    shown.close()
    assert inner.told[1] == f"figures for TensorBoard: tensorboard --logdir {tmp_path}/tensorboard"
    (file,) = (tmp_path / tensorboard.FOLDER).iterdir()
    content, at, found = file.read_bytes(), 0, list[tuple[str, int, float]]()
    while at < len(content):  # records: length, its checksum, the event, its checksum
        (size,) = struct.unpack_from("<Q", content, at)
        event = events.Event.FromString(content[at + 12 : at + 12 + size])
        found += [(each.tag, event.step, each.simple_value) for each in event.summary.value]
        at += 16 + size
    assert ("best_fitness", 1, 0.5) in found and ("strategy/sigma", 2, 0.25) in found


@pytest.mark.parametrize("fails", ["begin", "go on"])
def test_figures_that_cannot_be_written_leave_the_run_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fails: str
) -> None:
    writers: Any = pytest.importorskip("tensorboardX.event_file_writer")
    inner = Said()
    shown = tensorboard.TensorBoard(inner)
    shown.start(tmp_path, Config(experiment=toy.Toy(), seed=0), None)
    if fails == "go on":
        shown.generation(line(1))

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(writers.EventsWriter, "write_event", full)
    for generation in (2, 3):
        shown.generation(line(generation))
    shown.close()
    assert inner.told[-4:] == [
        "generation 2",
        "no more figures for TensorBoard: no space left on device",
        "generation 3",
        "close",
    ]
