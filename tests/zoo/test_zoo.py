"""Tests of the walkers that ship: what is written is what is read, and nothing else gets in."""

import io
import json
import shutil
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scripted
import toy

from mjxwalk import cli, experiments, runs, shipping, walkers, zoo
from mjxwalk.cli import main
from mjxwalk.errors import RunError
from mjxwalk.runs.npz import read_npz
from mjxwalk.runs.result import FILE as RESULT
from mjxwalk.runs.result import npz
from mjxwalk.zoo import entries

MOST_BYTES = 1 << 16  # of a file that ships; a walker with all links has 193 numbers


@pytest.fixture(scope="module")
def won(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a run with a tournament."""
    path = tmp_path_factory.mktemp("runs") / "a"
    changes = ["--set", "env.friction=0.5", "--set", "env.terrain.shape=steps"]
    with pytest.MonkeyPatch.context() as patch:
        toy.install(patch)
        args = ["--generations", "3", "--seed", "4", *changes, "--out", str(path)]
        assert main(["evolve", *args]) == 0
        assert main(["tournament", str(path), "--terrains", "20"]) == 0
    return path


@pytest.fixture
def house(won: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Returns a zoo of its own, in a folder with a run of the toy and its tournament."""
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)
    shutil.copytree(won, "a")
    folder = tmp_path / "zoo"
    folder.mkdir()
    monkeypatch.setattr(zoo, "FOLDER", folder)
    return folder


def test_a_winner_that_ships_comes_back_with_its_provenance(house: Path) -> None:
    shipping.ship(Path("a"), "toy-two", house)
    winner, shipped = walkers.best("a"), walkers.best("zoo:toy-two")
    assert (shipped.name, shipped.rank) == ("zoo:toy-two", "winner")
    assert shipped.experiment == winner.experiment
    assert shipped.generation == winner.generation
    for one, other in zip(winner.genotype, shipped.genotype, strict=True):
        np.testing.assert_array_equal(one, other)
    found = walkers.entrants("zoo:toy-two")
    assert found.generations.tolist() == [winner.generation]
    np.testing.assert_array_equal(found.genotypes.gain[0], winner.genotype.gain)
    told = zoo.provenance("toy-two")
    assert (told.seed, told.engine, told.mjxwalk) == (4, "mjx", runs.load("a").manifest["mjxwalk"])
    assert told.tournament.conditions[0].trials == 20
    assert zoo.names() == ["toy-two"]


def test_the_command_that_is_told_makes_the_same_run_again(house: Path) -> None:
    command = shipping.ship(Path("a"), "toy", house).command
    program, *args = command.split()
    assert program == "mjxwalk"
    assert main([*args, "--out", "again"]) == 0
    again = runs.load("again")
    assert experiments.of_run(again) == experiments.of_run(runs.load("a"))
    assert again.config == runs.load("a").config


@pytest.mark.slow  # evolves all phases of a study
def test_the_command_of_a_phase_makes_its_whole_study_again(house: Path) -> None:
    study, changes = next(iter(experiments.studies())), ["--scale", "0.5", "--seed", "2"]
    first = experiments.phases(study)[0]
    changes += ["--set", f"{first}.env.friction=0.5"]
    assert main(["evolve", study, *changes, "--out", "whole"]) == 0
    phases = sorted(path for path in Path("whole").iterdir() if path.is_dir())
    command = shipping.ship(phases[-1], "phase", house).command
    assert command.split() == [
        "mjxwalk",
        "evolve",
        study,
        "--seed",
        "2",
        "--scale",
        *changes[1:2],
        *changes[4:],
    ]


def test_a_walker_of_the_zoo_can_be_tried_and_is_listed(
    house: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shipping.ship(Path("a"), "toy", house)
    capsys.readouterr()
    before = {path: path.read_bytes() for path in house.iterdir()}
    assert main(["tournament", "zoo:toy", "--terrains", "5", "--json", "toy.json"]) == 0
    assert "the winner of zoo:toy" in capsys.readouterr().out
    assert json.loads(Path("toy.json").read_text())["entrants"] == 1
    assert {path: path.read_bytes() for path in house.iterdir()} == before
    assert main(["list"]) == 0
    assert "  zoo:toy  " in capsys.readouterr().out
    assert main(["tournament", "zoo:tox"]) == 2
    assert "no 'tox' in the zoo; did you mean toy?" in capsys.readouterr().err


def test_only_the_winner_of_the_newest_generation_ships(house: Path) -> None:
    Path("a/tournament.json").unlink()
    with pytest.raises(RunError, match="a has no winner; hold a tournament: mjxwalk tournament a"):
        shipping.ship(Path("a"), "toy", house)
    assert Path("a", RESULT).exists()
    assert not list(house.iterdir())


def test_the_script_ships_the_winner(house: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script = scripted.load("ship_winner")
    assert cli.run("ship_winner.py", script.ShipWinner, ["a", "toy"]) == 0
    assert capsys.readouterr().out.startswith("zoo:toy: ")
    assert sorted(path.name for path in house.iterdir()) == ["toy.json", "toy.npz"]
    assert cli.run("ship_winner.py", script.ShipWinner, ["nowhere", "toy"]) == 2
    assert capsys.readouterr().err.startswith("ship_winner.py: nowhere does not exist")


@pytest.mark.parametrize("name", ["", "../toy", "toy.json", "a b", "-"])
def test_a_name_that_is_no_files_is_refused(house: Path, name: str) -> None:
    with pytest.raises(RunError, match="letters, digits and hyphens, got"):
        shipping.ship(Path("a"), name, house)


def test_damaged_files_are_one_sentence(house: Path) -> None:
    shipping.ship(Path("a"), "toy", house)
    numbers, text = house / "toy.npz", house / "toy.json"
    whole, told = numbers.read_bytes(), text.read_bytes()

    def refused(complaint: str) -> None:
        with pytest.raises(RunError, match=complaint) as caught:
            walkers.best("zoo:toy")
        assert "\n" not in str(caught.value)

    for cut in (0, 10, len(whole) // 2, len(whole) - 1):
        numbers.write_bytes(whole[:cut])
        refused("toy.npz is damaged")
    numbers.write_bytes(npz({"gain": np.zeros((2, 3), np.float32)}))
    refused("toy.npz does not fit its experiment: bias is missing")
    numbers.unlink()
    refused("toy.npz could not be read: no such file or directory")
    numbers.write_bytes(whole)
    for content, complaint in (
        (told[:50], "cannot be read"),
        (told.replace(b'"schema": 1', b'"schema": 2'), "has version 2"),
        (told.replace(b'"friction": 0.5', b'"friction": "low"'), "friction must be a number"),
        (told.replace(b'"name": "toy"', b'"name": "toys"'), "unknown experiment 'toys'"),
    ):
        assert content != told
        text.write_bytes(content)
        refused(complaint)


def packed(compression: int = zipfile.ZIP_STORED, **members: bytes) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", compression) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return buffer.getvalue()


def saved(array: Any) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array, allow_pickle=True)
    return buffer.getvalue()


class Trap:
    """Says so if it is unpickled."""

    def __reduce__(self) -> Any:
        return pytest.fail, ("a pickle was opened",)


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (packed(gain=saved(np.array([Trap()], dtype=object))), "not plain numbers"),
        (packed(gain=saved(np.array(["text"]))), "not plain numbers"),
        (packed(zipfile.ZIP_DEFLATED, gain=saved(np.zeros(1 << 20))), "it is compressed"),
        (packed(gain=saved(np.zeros(4))[:-8]), r"24 bytes for float64\[4\]"),
        (packed(gain=saved(np.zeros(4)).replace(b"(4,)", b"(9,)")), r"32 bytes for float64\[9\]"),
        (packed(gain=b"no array"), "damaged"),
        (saved(np.zeros(4)), "damaged"),
    ],
)
def test_only_plain_numbers_of_a_sane_size_are_read(
    tmp_path: Path, content: bytes, complaint: str
) -> None:
    (tmp_path / "x.npz").write_bytes(content)
    with pytest.raises(RunError, match=complaint):
        read_npz(tmp_path / "x.npz")


def test_arrays_read_back_as_numpy_reads_them(tmp_path: Path) -> None:
    arrays = {
        "a": np.arange(6, dtype=np.float32).reshape(2, 3),
        "b": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        "c": np.asarray(2),
        "d": np.zeros((0, 2), bool),
    }
    (tmp_path / "x.npz").write_bytes(npz(arrays))
    read = read_npz(tmp_path / "x.npz")
    assert list(read) == list(arrays)
    for name, array in arrays.items():
        np.testing.assert_array_equal(read[name], array, strict=True)


@pytest.mark.parametrize("name", zoo.names())
def test_every_walker_that_ships_loads_and_is_small(name: str) -> None:
    walker = zoo.load(name)
    assert walker.name == f"zoo:{name}"
    told = entries.read(zoo.FOLDER, name)
    assert told.command.startswith("mjxwalk evolve")
    assert told.tournament.conditions[0].trials == 1000
    for ending in ("npz", "json"):
        assert (zoo.FOLDER / f"{name}.{ending}").stat().st_size < MOST_BYTES
