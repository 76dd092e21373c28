"""Tests of a run's folder and of its files: config, metrics, result, lock, and `load`."""

import json
from pathlib import Path

import numpy as np
import pytest
import toy

from mjxwalk import experiments, runs
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import (
    Champion,
    Metrics,
    Result,
    RunError,
    config,
    folder,
    metrics,
    result,
)

TOY = toy.Toy()


@pytest.fixture(autouse=True)
def toy_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    toy.install(monkeypatch)


def line(generation: int, best: float | None = 0.1) -> Metrics:
    return Metrics(
        generation=generation,
        best_fitness=best,
        mean_fitness=0.1,
        median_fitness=None,
        best_distance_m=1.0,
        mean_distance_m=1.0,
        median_distance_m=1.0,
        fall_share=0.5,
        diverged_share=0.0,
        speed_m_s=1.0,
        cost_of_transport=None,
        physics_steps=100,
        steps_per_s=10.0,
        evaluate_s=1.0,
        compile_s=0.0,
        other_s=0.5,
        strategy={"sigma": 0.2},
    )


def edit_config(path: Path, **changes: object) -> None:
    data = json.loads((path / config.FILE).read_text())
    (path / config.FILE).write_text(json.dumps({**data, **changes}))


def test_config_reads_back_equal(tmp_path: Path) -> None:
    settings = Config(experiment=TOY, seed=3, engine="mjx", keep=None, save_every=2)
    run_config.create(tmp_path / "a", settings)
    assert run_config.read(tmp_path / "a") == settings


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"seed": "three"}, "seed"),
        ({"seed": -1}, "seed must be from 0"),
        ({"colour": 1}, "colour"),
        ({"keep": 0}, "keep must be from 1 to 2147483647, got 0"),
        ({"schema": 99}, "version 99"),
        ({"seed": 1}, "was changed since it was written"),
        ({"digest": None}, "was changed since it was written"),
        ({"experiment": {"name": "toys"}}, "unknown experiment 'toys'"),
        ({"experiment": {"name": "toy"}}, "setting experiment.env is missing"),
    ],
)
def test_a_wrong_config_is_one_sentence(
    tmp_path: Path, changes: dict[str, object], complaint: str
) -> None:
    run_config.create(tmp_path / "a", Config(experiment=TOY))
    edit_config(tmp_path / "a", **changes)
    with pytest.raises(RunError, match=complaint) as caught:
        run_config.read(tmp_path / "a")
    assert "\n" not in str(caught.value)


def test_a_truncated_config_is_one_sentence(tmp_path: Path) -> None:
    run_config.create(tmp_path / "a", Config(experiment=TOY))
    file = tmp_path / "a" / config.FILE
    file.write_bytes(file.read_bytes()[:50])
    with pytest.raises(RunError, match="cannot be read"):
        runs.load(tmp_path / "a")


def test_a_setting_that_would_not_read_back_is_refused(tmp_path: Path) -> None:
    endless = toy.Toy(env=toy.World(friction=float("inf")))
    with pytest.raises(RunError, match="experiment"):
        run_config.create(tmp_path / "a", Config(experiment=endless))


def test_a_folder_in_use_is_refused(tmp_path: Path) -> None:
    run_config.create(tmp_path / "a", Config(experiment=TOY))
    with pytest.raises(RunError, match="already holds a run"):
        folder.check_free(tmp_path / "a")
    (tmp_path / "b").mkdir()
    folder.check_free(tmp_path / "b")
    (tmp_path / "b" / "thesis.tex").touch()
    with pytest.raises(RunError, match="not an empty folder"):
        folder.check_free(tmp_path / "b")
    with pytest.raises(RunError, match="not an empty folder"):
        folder.check_free(tmp_path / "b" / "thesis.tex")


def test_a_second_process_is_refused(tmp_path: Path) -> None:
    with folder.locked(tmp_path):
        assert folder.is_locked(tmp_path)
        with pytest.raises(RunError, match="another process"), folder.locked(tmp_path):
            pass
    assert not folder.is_locked(tmp_path)
    with folder.locked(tmp_path):
        pass


def test_metrics_are_exact_and_end_where_a_kill_cut_them(tmp_path: Path) -> None:
    third = float(np.float32(1) / np.float32(3))
    for generation in (1, 2, 3):
        metrics.append(tmp_path, line(generation, third))
    with (tmp_path / metrics.FILE).open("ab") as file:
        file.write(b'{"generation":4,"best_fi')
    lines = metrics.read(tmp_path)
    assert [each.generation for each in lines] == [1, 2, 3]
    assert lines[0].best_fitness == third
    assert metrics.cut(tmp_path, 2) == lines[:2]
    assert (tmp_path / metrics.FILE).read_bytes().count(b"\n") == 2


def test_columns_hold_nan_where_there_is_no_value() -> None:
    table = metrics.columns([line(1), line(2, None)])
    np.testing.assert_array_equal(table["best_fitness"], [0.1, np.nan])
    np.testing.assert_array_equal(table["strategy.sigma"], [0.2, 0.2])
    assert table["physics_steps"].dtype == np.int64


def test_champion_and_result_read_back(tmp_path: Path) -> None:
    champion = Champion(
        generation=2,
        distance_m=1.25,
        fall_rate=0.1,
        speed_m_s=None,
        cost_of_transport=0.3,
        terrains=10,
    )
    finished = Result(champion=champion, generations=3, wall_s=1.5, physics_steps=99)
    weights = {"gain": np.ones((2, 3), np.float32), "file": np.asarray(2.0)}
    result.write(tmp_path, finished, weights)
    assert result.read(tmp_path) == finished
    np.testing.assert_equal(result.read_genotype(tmp_path), weights)


def test_a_damaged_champion_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / result.CHAMPION_FILE).write_bytes(b"PK\x03\x04 and no more")
    with pytest.raises(RunError, match="damaged"):
        result.read_genotype(tmp_path)


def test_a_pickle_in_a_champion_is_not_opened(tmp_path: Path) -> None:
    with (tmp_path / result.CHAMPION_FILE).open("wb") as file:
        np.savez(file, allow_pickle=True, gain=np.array([{}], dtype=object))
    with pytest.raises(RunError, match="damaged"):
        result.read_genotype(tmp_path)


@pytest.mark.parametrize("name", ["nothing", "."])
def test_loading_what_is_no_run_is_one_sentence(tmp_path: Path, name: str) -> None:
    with pytest.raises(RunError, match="does not exist|no run"):
        runs.load(tmp_path / name)


def test_a_run_that_only_began_can_be_loaded(tmp_path: Path) -> None:
    run_config.create(tmp_path / "a", Config(experiment=TOY))
    run = runs.load(tmp_path / "a")
    assert run.generation == 0
    assert run.result is None
    assert run.champion == {}
    assert experiments.of_run(run) == TOY
    with pytest.raises(RunError, match="no checkpoint"):
        _ = run.fitness
