"""Tests of whole runs on disk: resumed, damaged, out of disk, and their champion."""

import dataclasses
import resource
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
import toy

from mjxwalk import runs
from mjxwalk.envs import Trials
from mjxwalk.evolution import Evolution, RunState
from mjxwalk.evolution.champions import choose
from mjxwalk.evolution.elites import Elites
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.rollout import Outcome
from mjxwalk.runs import Interrupted, Metrics, Result, RunError, checkpoints

# Orbax leaves its asynchronous work lying when a file of a checkpoint is damaged.
pytestmark = [
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore:coroutine:RuntimeWarning"),
]

SETTINGS = Config(experiment=toy.Toy(), keep=3)


class Watcher:
    """Takes down what is said, and acts on each generation."""

    def __init__(self, act: Callable[[int], None] | None = None) -> None:
        self.said: list[str] = []
        self._act = act

    def generation(self, line: Metrics) -> None:
        if self._act is not None:
            self._act(line.generation)

    def say(self, text: str) -> None:
        self.said.append(text)


def run(
    path: Path,
    settings: Config = SETTINGS,
    watcher: Watcher | None = None,
    stopping: Callable[[], bool] = lambda: False,
) -> Result:
    if not path.exists():
        run_config.create(path, settings)
    return toy.evolve(path, settings, watcher, stopping=stopping)


def stop_after(path: Path, generation: int, settings: Config = SETTINGS) -> None:
    done: list[int] = []
    with pytest.raises(Interrupted, match=f"after generation {generation}"):
        run(path, settings, Watcher(done.append), lambda: generation in done)


def same_run(one: Path, other: Path) -> bool:
    a, b = runs.load(one), runs.load(other)
    return (
        a.generation == b.generation
        and list(a.arrays) == list(b.arrays)
        and all(a.arrays[name].tobytes() == b.arrays[name].tobytes() for name in a.arrays)
        and a.result is not None
        and b.result is not None
        and a.result.champion == b.result.champion
        and (one / "champion.npz").read_bytes() == (other / "champion.npz").read_bytes()
        and all(
            np.array_equal(a.metrics[name], b.metrics[name], equal_nan=True)
            for name in a.metrics
            if not name.endswith("_s") or name == "speed_m_s"  # all but wall times
        )
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("runs") / "whole"
    run(path)
    return path


@pytest.fixture
def resumable(whole: Path, tmp_path: Path) -> Path:
    """A copy of the run as a kill after its last checkpoint would leave it."""
    path = tmp_path / "resumable"
    shutil.copytree(whole, path)
    (path / "result.json").unlink()
    (path / "champion.npz").unlink()
    return path


def test_a_finished_run_has_all_its_parts(whole: Path) -> None:
    loaded = runs.load(whole)
    assert loaded.generation == 6
    assert loaded.generations == [4, 5, 6]
    assert loaded.metrics["generation"].tolist() == [1, 2, 3, 4, 5, 6]
    assert loaded.population["gain"].shape == (16, 2, 3)
    assert loaded.fitness.shape == (16,)
    assert loaded.elites["bias"].shape == (50,)
    assert "mask.gain" in loaded.strategy_state
    assert loaded.champion["gain"].shape == (2, 3)
    assert loaded.result is not None
    assert loaded.result.physics_steps == loaded.metrics["physics_steps"].sum()
    seconds = sum(loaded.metrics[f"{part}_s"] for part in ("evaluate", "compile", "other"))
    assert loaded.result.wall_s == pytest.approx(np.sum(seconds))


def test_an_older_generation_can_be_loaded(whole: Path) -> None:
    assert runs.load(whole, 4).arrays["generation"] == 4
    with pytest.raises(RunError, match="no checkpoint of generation 1"):
        runs.load(whole, 1)


def test_a_run_twice_is_the_same(whole: Path, tmp_path: Path) -> None:
    run(tmp_path / "again")
    assert same_run(whole, tmp_path / "again")


@pytest.mark.parametrize("save_every", [1, 4])
def test_a_stopped_run_resumes_to_the_same_bits(
    whole: Path, tmp_path: Path, save_every: int
) -> None:
    settings = dataclasses.replace(SETTINGS, save_every=save_every)
    stop_after(tmp_path / "a", 3, settings)
    assert runs.load(tmp_path / "a").generation == 3
    run(tmp_path / "a", settings)
    assert same_run(whole, tmp_path / "a")


def test_a_run_stopped_before_its_first_generation_starts_again(
    whole: Path, tmp_path: Path
) -> None:
    with pytest.raises(Interrupted):
        run(tmp_path / "a", stopping=lambda: True)
    run(tmp_path / "a")
    assert same_run(whole, tmp_path / "a")


def test_lines_newer_than_the_checkpoint_are_cut(whole: Path, resumable: Path) -> None:
    for generation in (5, 6):
        shutil.rmtree(resumable / "checkpoints" / str(generation))
    with (resumable / "metrics.jsonl").open("ab") as file:
        file.write(b'{"generation": 7, "best')
    run(resumable)
    assert same_run(whole, resumable)


def test_a_truncated_last_checkpoint_falls_back_and_says_so(whole: Path, resumable: Path) -> None:
    array = resumable / "checkpoints" / "6" / "arrays" / "0"
    array.write_bytes(array.read_bytes()[:100])
    watcher = Watcher()
    run(resumable, watcher=watcher)
    assert "damaged" in watcher.said[0]
    assert watcher.said[1] == "going on from generation 5, the newest that is whole"
    assert same_run(whole, resumable)


def test_a_run_without_a_whole_checkpoint_is_one_sentence(resumable: Path) -> None:
    for generation in checkpoints.generations(resumable / "checkpoints"):
        (resumable / "checkpoints" / str(generation) / "_CHECKPOINT_METADATA").unlink()
    with pytest.raises(RunError, match="no checkpoint of .* can be read"):
        run(resumable)
    assert checkpoints.generations(resumable / "checkpoints") == [4, 5, 6]


def test_a_run_whose_checkpoints_were_removed_keeps_its_figures(resumable: Path) -> None:
    shutil.rmtree(resumable / "checkpoints")
    with pytest.raises(RunError, match="no checkpoint of .* can be read"):
        run(resumable)
    assert len(runs.load(resumable).metrics["generation"]) == 6


def test_a_checkpoint_of_other_settings_is_refused(resumable: Path) -> None:
    other = dataclasses.replace(SETTINGS, experiment=toy.Toy(population_size=8))
    with pytest.raises(RunError, match="of another experiment"):
        run(resumable, other)


def test_a_full_disk_stops_the_run_and_freed_it_goes_on(whole: Path, tmp_path: Path) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill_disk(generation: int) -> None:
        if generation == 3:
            # Files of more than 2 kB cannot grow, as on a full disk; checkpoints have larger ones.
            resource.setrlimit(resource.RLIMIT_FSIZE, (2000, hard))

    try:
        with pytest.raises(RunError, match="full|too large"):
            run(tmp_path / "a", watcher=Watcher(fill_disk))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    # The third may have been half written, or done, when the disk was full.
    assert runs.load(tmp_path / "a").generation in (2, 3)
    run(tmp_path / "a")
    assert same_run(whole, tmp_path / "a")


class Fixed:
    """An evaluator with made-up distances [elite, terrain]; genotypes are places of elites."""

    compile_s = 0.0

    def __init__(self, distance: Any) -> None:
        self._distance = np.asarray(distance, np.float32)
        self._used = 0

    def evaluate(self, population: Any, trials: Trials) -> Outcome:
        # Each call brings new terrains.
        columns = slice(self._used, self._used + trials.num)
        self._used = columns.stop
        d = self._distance[np.asarray(population, int), columns]
        arrays = (d, d, np.full_like(d, 2.0), d < 1, d < 1, d, np.ones_like(d), d.astype(np.int32))
        return Outcome(*arrays)  # type: ignore[arg-type]


def ended(generations: list[int], *, reached: bool = False) -> RunState:
    """Returns the end of a run whose elites are the numbers of their places."""
    study = toy.Toy()
    state = Evolution(study, toy.ToyEvaluator(study, "mjx")).start(0)
    num = len(generations)
    elites = Elites(
        genotypes=np.arange(float(num)),
        fitness=np.zeros(num, np.float32),
        generation=np.array(generations, np.int32),
    )
    return state._replace(
        generation=np.asarray(8), elites=elites, elite=np.asarray(1.0), reached=np.asarray(reached)
    )


def test_the_champion_is_chosen_on_other_terrains_than_it_is_reported_on() -> None:
    # Elite 1 is the best where it is chosen and bad afterwards; elite 2 is the other way round, and
    # elite 0 is an empty place.
    stages = (([9.0, 5.0, 4.0], 110), ([9.0, 0.5, 8.0], 10))
    distance = np.hstack([np.repeat(np.array([part]).T, num, axis=1) for part, num in stages])
    choice = choose(toy.Toy(), Fixed(distance), ended([0, 7, 8]), jax.random.key(0))
    assert choice.genotype == 1.0
    assert choice.champion == runs.Champion(
        generation=7,
        distance_m=0.5,
        fall_rate=1.0,
        speed_m_s=0.25,
        cost_of_transport=0.2,  # 1 J a trial, 10 N, 0.5 m
        terrains=10,
        fitness=0.5,
    )


def test_of_the_finalists_the_one_that_falls_least_is_champion() -> None:
    # Elite 0 gets farther, but falls (a distance below 1) once in the 100 trials that choose.
    distance = np.repeat([[9.0], [5.0]], 120, axis=1)
    distance[0, 40] = 0.5
    choice = choose(toy.Toy(), Fixed(distance), ended([7, 8]), jax.random.key(0))
    assert choice.genotype == 1.0 and choice.champion.generation == 8


def test_who_reached_the_goal_is_champion() -> None:
    distance = np.repeat([[9.0], [5.0]], 10, axis=1)
    choice = choose(toy.Toy(), Fixed(distance), ended([7, 6], reached=True), jax.random.key(0))
    assert choice.genotype == 1.0 and choice.champion.generation == 8
    assert choice.champion.distance_m == 5.0
