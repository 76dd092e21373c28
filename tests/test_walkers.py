"""Tests of where walkers come from, on runs of the toy."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import toy

from mjxwalk import cli, runs, tournament, walkers
from mjxwalk.errors import RunError
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import config, result
from mjxwalk.runs.npz import npz
from mjxwalk.runs.result import CHAMPION_FILE, FILE
from mjxwalk.tournament import Tournament, results


@pytest.fixture(scope="module")
def evolved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a finished run."""
    path = tmp_path_factory.mktemp("runs") / "a"
    with pytest.MonkeyPatch.context() as patch:
        toy.install(patch)
        assert cli.main(["evolve", "--generations", "3", "--out", str(path)]) == 0
    return path


@pytest.fixture(autouse=True)
def toy_run(evolved: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)
    shutil.copytree(evolved, "a")


def held(winner: int, newest: int) -> Tournament:
    return Tournament(
        entrants=3,
        newest_generation=newest,
        winner_generation=winner,
        screening_terrains=2,
        seed=0,
        engine="mjx",
        roughness_m=None,
        conditions=(),
    )


def test_a_run_offers_the_elites_of_its_generations_newest_last() -> None:
    found = walkers.entrants("a")
    assert found.generations.tolist() == [1, 2, 3]
    assert len(found) == 3
    for generation in (1, 2, 3):
        elite = runs.load("a", generation).elite
        np.testing.assert_array_equal(found.of_generation(generation).gain, elite["gain"])
    with pytest.raises(ValueError, match="a has no walker of generation 4"):
        found.of_generation(4)


def test_best_is_the_winner_then_the_champion_then_the_fittest_so_far() -> None:
    found = walkers.entrants("a")
    tournament.write(Path("a"), held(2, 3), found.of_generation(2))
    winner = walkers.best("a")
    assert (winner.rank, winner.generation) == ("winner", 2)
    np.testing.assert_array_equal(winner.genotype.gain, found.of_generation(2).gain)

    Path("a", results.FILE).unlink()
    champion = walkers.best(Path("a"))
    assert champion.rank == "champion"
    np.testing.assert_array_equal(champion.genotype.gain, runs.load("a").champion["gain"])

    Path("a", FILE).unlink()
    fittest = walkers.best("a")
    assert (fittest.rank, fittest.generation) == ("fittest", 3)
    np.testing.assert_array_equal(fittest.genotype.gain, found.of_generation(3).gain)


def test_a_run_that_has_gone_on_since_its_tournament_has_no_winner() -> None:
    tournament.write(Path("a"), held(1, 2), walkers.entrants("a").of_generation(1))
    assert walkers.best("a").rank == "champion"


@pytest.mark.parametrize(
    "source", ["nowhere", "empty", "several", "begun", "damaged", "zoo:nobody"]
)
def test_a_source_without_walkers_is_one_sentence(source: str) -> None:
    Path("empty").mkdir()
    for name in ("begun", "several/1-lpd", "several/2-fil"):
        run_config.create(Path(name), Config(experiment=toy.Toy()))
    run_config.create(Path("damaged"), Config(experiment=toy.Toy()))
    Path("damaged/checkpoints/1").mkdir(parents=True)
    complaint = {
        "nowhere": "nowhere does not exist",
        "empty": f"empty is no run: it has no {config.FILE}",
        "several": "several holds several runs; name one of several/1-lpd, several/2-fil",
        "begun": "begun has not saved a generation yet",
        "damaged": "damaged has no checkpoint that can be read: .*is damaged",
        "zoo:nobody": "there is no 'nobody' in the zoo",
    }[source]
    for ask in (walkers.entrants, walkers.best):
        with pytest.raises(RunError, match=complaint) as caught:
            ask(source)
        assert "\n" not in str(caught.value)


def test_weights_of_another_experiment_are_refused() -> None:
    weights = {"gain": np.zeros((3, 3), np.float32), "bias": np.zeros((), np.float32)}
    Path("a", CHAMPION_FILE).write_bytes(npz(weights))
    with pytest.raises(RunError, match="champion.npz is not the file that its run wrote"):
        walkers.best("a")
    finished = result.read(Path("a"))
    assert finished is not None
    result.write(Path("a"), finished, weights)
    with pytest.raises(RunError, match="a holds walkers of another experiment: gain must be"):
        walkers.best("a")
