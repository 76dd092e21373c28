"""Mutates the files of a finished run, and looks at what mjxwalk makes of them.

    python tests/robustness/mutating.py 1000

A mutated run may be refused with a sentence, or read as what it was: the same settings, figures up
to some generation, arrays of a generation to the bit. Anything else is a fault.
"""

import collections
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import toy

from mjxwalk import runs, tournament
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.experiments.study_config import StudyConfig
from mjxwalk.runs import RunError, digests, folder, manifest
from mjxwalk.tournament import results

Random = np.random.Generator
Mutation = Callable[[bytearray, Random], bytearray]

HOSTILE: tuple[Any, ...] = (
    -1, 0, 2**63, 10**30, 1e308, -1e-320, True, None, "", "../../../etc/passwd",
    "x" * 100_000, [], {}, [[]] * 1000, {"": {}}, [10**18, 10**18],
)  # fmt: skip


def make(path: Path, seed: int = 0) -> None:
    """Makes the run that is mutated, and others of its shape."""
    settings = Config(experiment=toy.Toy(), seed=seed, keep=3)
    run_config.create(path, settings)
    manifest.write(path, engine="mjx", why="", devices="", settings={})
    toy.evolve(path, settings)
    study = StudyConfig(name="toy", phases=(("only", toy.Toy()),))
    toy.hold_tournament(path, study, lambda text: None)


def flip(content: bytearray, random: Random) -> bytearray:
    """Flips one bit."""
    content[random.integers(len(content))] ^= 1 << random.integers(8)
    return content


def overwrite(content: bytearray, random: Random) -> bytearray:
    """Writes noise over some bytes."""
    start, length = random.integers(len(content)), random.integers(1, 64)
    content[start : start + length] = random.bytes(len(content[start : start + length]))
    return content


def truncate(content: bytearray, random: Random) -> bytearray:
    """Cuts the end off."""
    return content[: random.integers(len(content))]


def blank(content: bytearray, random: Random) -> bytearray:
    """Writes zeros over a block, as a disk that lost one does."""
    start = random.integers(len(content))
    content[start : start + 512] = bytes(len(content[start : start + 512]))
    return content


def remove(content: bytearray, random: Random) -> bytearray:
    """Takes some bytes out of the middle."""
    start, length = random.integers(len(content)), random.integers(1, 64)
    del content[start : start + length]
    return content


def repeat(content: bytearray, random: Random) -> bytearray:
    """Puts some bytes in twice."""
    start, length = random.integers(len(content)), random.integers(1, 64)
    content[start:start] = content[start : start + length]
    return content


def digit(content: bytearray, random: Random) -> bytearray:
    """Puts another digit in the place of one: the file stays well-formed, if it is text."""
    places = [i for i, byte in enumerate(content) if 48 <= byte < 58]
    if not places:
        return flip(content, random)
    place = random.choice(places)
    content[place] = 48 + (content[place] - 48 + random.integers(1, 10)) % 10
    return content


def grow(content: bytearray, random: Random) -> bytearray:
    """Adds bytes at the end."""
    return content + random.bytes(int(random.integers(1, 5000)))


def value(content: bytearray, random: Random) -> bytearray:
    """Puts a hostile value in a place of a JSON file, with a digest that fits if it had one."""
    try:
        data = msgspec.json.decode(content)
    except (msgspec.DecodeError, UnicodeDecodeError):
        return flip(content, random)
    places: list[tuple[Any, Any]] = []
    _collect(data, places)
    if not places:
        return flip(content, random)
    table, key = places[random.integers(len(places))]
    table[key] = HOSTILE[random.integers(len(HOSTILE))]
    has_digest = isinstance(data, dict) and digests.DIGEST in data
    return bytearray(digests.with_digest(data) if has_digest else msgspec.json.encode(data))


def _collect(data: Any, places: list[tuple[Any, Any]]) -> None:
    items = data.items() if isinstance(data, dict) else enumerate(data)
    for key, inside in items:
        places.append((data, key))
        if isinstance(inside, dict | list):
            _collect(inside, places)


DAMAGES: tuple[Mutation, ...] = (
    flip, overwrite, truncate, blank, remove, repeat, digit, grow
)  # fmt: skip


def mutate(path: Path, other_run: Path, random: Random) -> tuple[str, bool]:
    """Mutates one file of a run; returns what was done, and whether it was a forgery.

    Args:
      path: of the run.
      other_run: one of the same shape, to take files from.
      random: draws the file and what is done to it.
    """
    files = sorted(each for each in path.rglob("*") if each.is_file())
    victim = files[random.integers(len(files))]
    name = str(victim.relative_to(path))
    kind = random.integers(15)
    if kind == 0:
        victim.unlink()
        return f"{name} removed", False
    if kind == 1:
        victim.unlink()
        victim.mkdir()
        return f"{name} a folder", False
    if kind == 2:
        other = files[random.integers(len(files))]
        victim.write_bytes(other.read_bytes())
        return f"{name} replaced by {other.relative_to(path)}", False
    if kind == 12:
        victim.unlink()
        os.mkfifo(victim)
        return f"{name} a pipe", False
    if kind == 13:
        away = path.with_name("away")
        victim.replace(away)
        victim.symlink_to(away)
        return f"{name} a link", False
    if kind == 14 and (other_run / name).is_file():
        shutil.copy(other_run / name, victim)
        return f"{name} of another run", False
    mutation = value if kind == 3 else DAMAGES[random.integers(len(DAMAGES))]
    content = victim.read_bytes()
    victim.write_bytes(mutation(bytearray(content), random) if content else b"?")
    return f"{name}: {mutation.__name__}", mutation is value


class Whole:
    """The run as it was, to compare with."""

    def __init__(self, path: Path) -> None:
        self.run = runs.load(path)
        self.settings = run_config.read(path)
        self.held, self.winner = tournament.read(path), _bits(results.read_winner(path))
        self.arrays = {g: _bits(runs.load(path, g).arrays) for g in self.run.generations}

    def judge(self, path: Path, *, is_forged: bool) -> str:
        """Returns what mjxwalk makes of a mutated copy.

        "refused", read without a "damaged" checkpoint, "unfinished" for want of a result, or the
        "same".

        Args:
          path: of the copy.
          is_forged: whether a file was written anew with a digest that fits: what it says then is
            what somebody wanted to say, and may be read.

        Raises:
          AssertionError: something else was loaded than there was.
          Exception: it crashed.
        """
        try:
            loaded = runs.load(path)
            settings = run_config.read(path)
            held = tournament.read(path)
            winner = self.winner if held is None else _bits(results.read_winner(path))
        except RunError as error:
            assert "\n" not in str(error), f"more than a sentence: {error}"
            return "refused"
        if is_forged:
            return "same"
        assert settings == self.settings, "other settings"
        assert held in (None, self.held) and winner == self.winner, "another tournament"
        assert loaded.manifest in ({}, self.run.manifest), "another manifest"
        for name, column in loaded.metrics.items():
            np.testing.assert_array_equal(column, self.run.metrics[name][: column.size])
        if loaded.generation:
            assert _bits(loaded.arrays) == self.arrays[loaded.generation], "other arrays"
        damaged = [number for number in self.arrays if not self._is_whole(path, number)]
        if damaged:
            return "damaged"
        if loaded.result is None:
            return "unfinished"
        assert loaded.result == self.run.result, "another result"
        assert _bits(loaded.champion) == _bits(self.run.champion), "another champion"
        return "same"

    def _is_whole(self, path: Path, generation: int) -> bool:
        try:
            arrays = runs.load(path, generation).arrays
        except RunError:
            return False
        assert _bits(arrays) == self.arrays[generation], f"other arrays of {generation}"
        return True

    def check_resume(self, path: Path) -> None:
        """Goes on with a mutated copy, which must end as the run did, or be refused."""
        for name in ("result.json", "champion.npz"):
            if (path / name).is_file():
                (path / name).unlink()
        try:
            settings = run_config.read(path)
            with folder.locked(path):
                toy.evolve(path, settings)
            loaded = runs.load(path)
        except RunError:
            return
        assert _bits(loaded.arrays) == self.arrays[self.run.generation], "resumed to other arrays"
        assert _bits(loaded.champion) == _bits(self.run.champion), "resumed to another champion"


def _bits(arrays: dict[str, Any]) -> dict[str, bytes]:
    return {name: array.tobytes() for name, array in arrays.items()}


def attack(number: int, seed: int, place: Path, *, resume_every: int = 5) -> dict[str, int]:
    """Returns how many mutations ended in which way.

    Raises:
      AssertionError: one was loaded as something else, or crashed; names it.
    """
    random = np.random.default_rng(seed)
    make(place / "whole")
    make(place / "other", seed=1)
    whole = Whole(place / "whole")
    counts: collections.Counter[str] = collections.Counter()
    for turn in range(number):
        path = place / "mutated"
        shutil.rmtree(path, ignore_errors=True)
        shutil.copytree(place / "whole", path)
        what, is_forged = mutate(path, place / "other", random)
        try:
            counts[whole.judge(path, is_forged=is_forged)] += 1
            if turn % resume_every == 0 and not is_forged:
                whole.check_resume(path)
                counts["resumed"] += 1
        except Exception as error:
            raise AssertionError(f"mutation {turn} of seed {seed}, {what}: {error!r}") from error
    return dict(counts)


if __name__ == "__main__":
    toy.install(pytest.MonkeyPatch())
    with tempfile.TemporaryDirectory() as folder_of_all:
        print(attack(int(sys.argv[1]), seed=0, place=Path(folder_of_all)))
