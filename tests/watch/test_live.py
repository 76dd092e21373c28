"""Tests of what looks on while a run goes on: its page on localhost, and TensorBoard."""

import struct
import time
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

import msgspec
import pytest
import toy
from watch import given

from mjxwalk.runs import Config, Metrics, config
from mjxwalk.watch import bodies, live, recording, tensorboard
from mjxwalk.watch.casting import Cast
from mjxwalk.watch.grounds import Ground
from mjxwalk.watch.recording import Show, Trial


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


def nothing_walks(cast: Cast, trial: Trial) -> tuple[Show, str]:
    """Stands for the recording, which other tests are of."""
    del trial
    ground = Ground(x=0.0, y=0.0, spacing=0.1, rows=1, width=1.0)
    body = bodies.describe(cast.experiment.env)
    show = Show(
        title=cast.source,
        what=cast.what,
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
    shown.start(run, config.read(run), None)
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


def test_a_port_that_is_taken_is_another() -> None:
    first = live.Live(Said(), port=0)
    server: Any = live.listen(first, 0)
    second: Any = live.listen(first, server.server_address[1])
    assert second.server_address[1] != server.server_address[1]
    assert server.server_address[0] == second.server_address[0] == "127.0.0.1"
    server.server_close()
    second.server_close()


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
