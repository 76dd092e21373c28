"""Tests of the command `mjxwalk watch`, and of which walkers it shows."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from player import given
from player.given import PLANAR

from mjxwalk import cli, experiments, walkers
from mjxwalk.errors import RunError
from mjxwalk.player import shown_walkers
from mjxwalk.walker import Walker


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a run with checkpoints of generations 3 to 5, and elites of 4 and 5."""
    path = tmp_path_factory.mktemp("runs") / "run"
    given.make_run(path)
    return path


def complaint(capsys: pytest.CaptureFixture[str], *args: str) -> str:
    """Returns the one sentence that a wrong command gets."""
    assert cli.main(["watch", *args]) == 2
    written = capsys.readouterr()
    assert not written.out and written.err.count("\n") == 1
    return written.err


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("nowhere",), "nowhere does not exist"),
        (("zoo:planar-lpx",), "there is no 'planar-lpx' in the zoo; did you mean planar-lpd"),
        ((PLANAR, "--roughness", "-0.1"), "--roughness must be from 0 to 0.2 m, got -0.1"),
        ((PLANAR, "--roughness", "3"), "--roughness must be from 0 to 0.2 m, got 3"),
        ((PLANAR, "--walkers", "17"), "--walkers must be from 1 to 16, got 17"),
        ((PLANAR, "--champions", "0"), "--champions must be from 1 to 16, got 0"),
        ((PLANAR, "--champions", "3", "--walkers", "3"), "give one"),
        ((PLANAR, "--champions", "3", "--generation", "3"), "leave out --generation"),
        ((PLANAR, "--generation", "0"), "--generation must be at least 1, got 0"),
        ((PLANAR, "--terrain-seed", "-1"), "--terrain-seed must be a whole number"),
        ((PLANAR, "--seconds", "0"), "--seconds must be from 0.1 to 600, got 0"),
        ((PLANAR, "--out", "missing/a.html"), "make missing first"),
        ((PLANAR, "--out", "."), "--out . is a folder; name a file in it"),
        ((PLANAR, "--generation", "7"), "has no walker of generation 7; it has generation 56"),
        ((PLANAR, "--walkers", "2"), "zoo:planar-lpd is one walker and has no population"),
        ((PLANAR, "--champions", "2"), "is one walker and has no champions"),
    ],
)
def test_wrong_input_gets_a_sentence(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    args: tuple[str, ...],
    words: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert words in complaint(capsys, *args)
    assert not list(tmp_path.iterdir())


def test_a_generation_that_is_gone_gets_a_sentence(
    capsys: pytest.CaptureFixture[str], run: Path
) -> None:
    told = complaint(capsys, str(run), "--generation", "2")
    assert "has no walker of generation 2; it has generation 3 to 5" in told
    told = complaint(capsys, str(run), "--generation", "2", "--walkers", "4")
    assert "no population of generation 2 any more" in told and "--keep all" in told


def blend_times(shown: shown_walkers.ShownWalkers) -> list[float]:
    return np.asarray(shown.genotypes.blend_time).tolist()


def test_the_fittest_of_each_generation_can_be_had(run: Path) -> None:
    assert blend_times(shown_walkers.best(run)) == [5.0]
    for generation in (3, 4, 5):  # 3 is in its checkpoint alone, 4 among the elites
        assert blend_times(shown_walkers.fittest(run, generation)) == [float(generation)]


def test_champions_are_spread_over_the_generations_newest_first(run: Path) -> None:
    shown = shown_walkers.champions(run, 16)
    assert shown.labels == ("generation 5", "generation 4", "generation 3")
    assert blend_times(shown) == [5.0, 4.0, 3.0]
    assert shown_walkers.champions(run, 2).labels == ("generation 5", "generation 3")
    assert shown_walkers.champions(run, 1).labels == ("generation 5",)


def test_a_population_is_shown_fittest_first_and_nan_last(run: Path) -> None:
    shown = shown_walkers.population(run, 16, 4)
    assert blend_times(shown) == [4.0, 0.0] and shown.labels == ("rank 1", "rank 2")
    assert shown.what == "all of 2 in generation 4"
    assert shown_walkers.population(run, 1, None).what == "fittest 1 of 2 in generation 5"


def test_ranges_are_told_in_few_words() -> None:
    told = shown_walkers.ranges
    assert told([3]) == "generation 3"
    assert told([1, 2, 3, 7, 9, 10]) == "generation 1 to 3, 7, 9 to 10"
    assert told([1, 3, 5, 7, 9, 11, 12]) == "generation 1, 3, others, 11 to 12"
    assert told([]) == ""


def test_a_fit_walks_nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    fit: Any = experiments.get("rayleigh")
    found = dataclasses.replace(walkers.best(PLANAR), experiment=fit)

    def best(_: object) -> Walker:
        return found

    monkeypatch.setattr(walkers, "best", best)
    with pytest.raises(RunError, match="is a fit, in which nothing walks"):
        shown_walkers.best("runs/fit")


def test_the_page_is_written_where_it_is_told(
    capsys: pytest.CaptureFixture[str], run: Path, tmp_path: Path
) -> None:
    out = tmp_path / "page.html"
    assert (
        cli.main(["watch", str(run), "--champions", "2", "--seconds", "1", "--out", str(out)]) == 0
    )
    written = capsys.readouterr().out.splitlines()
    assert written[-1] == str(out) and written[0].startswith("generation 5: ")
    assert out.read_text().startswith("<!doctype html>")
    assert cli.main(["watch", str(run), "--seconds", "1", "--roughness", "0.01"]) == 0
    assert (run / "watch.html").exists() and "10 mm" in (run / "watch.html").read_text()
