"""Tests of what runs start from, as a file and as taken from other runs."""

import dataclasses
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import toy

from mjxwalk import runs, walkers
from mjxwalk.evolution import Evolution
from mjxwalk.evolution.inheritance import inherit
from mjxwalk.experiments import run_config
from mjxwalk.experiments.pruning import Pruning
from mjxwalk.experiments.run_config import Config
from mjxwalk.experiments.scaling import scaled
from mjxwalk.runs import RunError, config, folder, inheritance
from mjxwalk.runs.config import Origin
from mjxwalk.runs.inheritance import Inherited
from mjxwalk.runs.trees import flatten

TOY = toy.Toy()
NEAR = dataclasses.replace(TOY, start="winner")
GOING_ON = dataclasses.replace(TOY, start="population")


@pytest.fixture(autouse=True)
def toy_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    toy.install(monkeypatch)


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run of the toy."""
    path = tmp_path_factory.mktemp("runs") / "source"
    with pytest.MonkeyPatch.context() as patch:
        toy.install(patch)
        settings = Config(experiment=TOY)
        run_config.create(path, settings)
        toy.evolve(path, settings)
    return path


def begin(experiment: Any, given: Inherited | None, seed: int = 0) -> Any:
    return Evolution(experiment, toy.ToyEvaluator(experiment, "auto")).start(seed, given)


def test_a_start_reads_back_to_the_same_bits(tmp_path: Path) -> None:
    fitness = np.array([1.0, np.nan], np.float32)
    written = Inherited({"a.b": np.ones(3)}, {"mask": np.array(True)}, fitness)
    run_config.create(tmp_path, Config(experiment=TOY), written)
    read = inheritance.read(tmp_path)
    np.testing.assert_equal(read, written)
    assert read.elite_fitness.tobytes() == fitness.tobytes()


def test_a_missing_or_damaged_start_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="lacks start.npz"):
        inheritance.read(tmp_path)
    run_config.create(tmp_path, Config(experiment=TOY))
    (tmp_path / inheritance.FILE).write_bytes(b"PK\x03\x04 and no more")
    with pytest.raises(RunError, match="start.npz is damaged"):
        inheritance.read(tmp_path)


def test_a_start_of_another_run_is_refused(tmp_path: Path) -> None:
    for name, value in (("a", 1.0), ("b", 2.0)):
        given = Inherited({"gain": np.full(3, value)}, {}, np.zeros(0))
        run_config.create(tmp_path / name, Config(experiment=TOY), given)
    (tmp_path / "b" / inheritance.FILE).replace(tmp_path / "a" / inheritance.FILE)
    with pytest.raises(RunError, match="start.npz is not the file that its run wrote"):
        inheritance.read(tmp_path / "a")


def test_a_folder_that_a_killed_process_began_is_free(tmp_path: Path) -> None:
    inheritance.write(tmp_path, Inherited({}, {}, np.zeros(0)))
    (tmp_path / ".config.json.partial").touch()
    folder.check_free(tmp_path)
    (tmp_path / "thesis.tex").touch()
    with pytest.raises(RunError, match="not an empty folder"):
        folder.check_free(tmp_path)


def test_generation_0_is_drawn_around_the_winner(source: Path) -> None:
    given, origin = inherit(NEAR, source)
    winner = walkers.best(source)
    assert origin == Origin(source=str(source), generation=winner.generation)
    state = begin(dataclasses.replace(NEAR, population_size=4000), given)
    off = state.strategy.population.gain - winner.genotype.gain
    # Of 4000 draws the mean is known to 0.3 / 63, the deviation to 0.3 / 89; four of those.
    np.testing.assert_allclose(off.mean(axis=0), 0.0, atol=0.02)
    np.testing.assert_allclose(off.std(axis=0), 0.3, atol=0.014)


def test_a_population_goes_on_with_its_strategy_s_state(source: Path) -> None:
    given, origin = inherit(GOING_ON, source)
    assert origin.generation == 6
    before = runs.load(source)
    state = begin(GOING_ON, given)
    for name, array in flatten(state.strategy).items():
        np.testing.assert_array_equal(array, before.strategy_state[name])
    assert int(state.generation) == 0


def test_pruning_compares_with_the_elites_of_the_run_before(source: Path) -> None:
    pruned = dataclasses.replace(GOING_ON, pruning=Pruning(reference=5, window=3))
    given, _ = inherit(pruned, source)
    state = begin(pruned, given)
    elites = runs.load(source).part("elites")["fitness"]
    assert np.isfinite(elites).sum() == 6
    np.testing.assert_array_equal(state.strategy.reference, elites[-5:])
    np.testing.assert_array_equal(state.strategy.recent, elites[-3:])
    assert state.strategy.age == 0
    # And a pruned population can be taken over in its turn, without what pruned it.
    names = {f"inner.{name}" for name in given.strategy}
    assert names < set(flatten(state.strategy))


def test_phases_of_one_seed_share_no_random_numbers(source: Path) -> None:
    keys = [begin(TOY, None).key]
    keys += [begin(e, inherit(e, source)[0]).key for e in (NEAR, GOING_ON)]
    assert len({key.tobytes() for key in keys}) == 3
    assert keys[0].tobytes() == np.asarray(jax.random.key_data(jax.random.key(0))).tobytes()


class Other(NamedTuple):
    """Weights of the toy's shapes and another meaning."""

    gain: Any
    bias: Any


class OtherToy(toy.Toy):
    """A toy whose walkers have other weights."""

    def template(self) -> Any:
        """Returns zeros."""
        return Other(jnp.zeros((2, 3)), jnp.zeros(()))


class WiderToy(toy.Toy):
    """A toy whose walkers have more inputs."""

    def template(self) -> toy.Genotype:
        """Returns zeros."""
        return toy.Genotype(jnp.zeros((2, 4)), jnp.zeros(()))


@pytest.mark.parametrize(
    ("experiment", "complaint"),
    [
        (OtherToy(start="winner"), "holds the weights of another controller"),
        (OtherToy(start="population"), "holds the weights of another controller"),
        (WiderToy(start="winner"), r"cannot start from .*: gain must be float32\[2, 4\], got"),
        (WiderToy(start="population"), r"cannot start from .*: population.gain must be"),
        (scaled(GOING_ON, 0.7), "has a population of 16 and this experiment one of 11; set --popu"),
    ],
)
def test_a_source_that_does_not_fit_is_one_sentence(
    unchecked_types: None, source: Path, experiment: Any, complaint: str
) -> None:
    with pytest.raises(RunError, match=complaint) as caught:
        inherit(experiment, source)
    assert "\n" not in str(caught.value)


def test_a_source_without_a_population_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="zoo:any is a single walker"):
        inherit(GOING_ON, "zoo:any")
    run_config.create(tmp_path / "a", Config(experiment=TOY))
    for experiment in (NEAR, GOING_ON):
        with pytest.raises(RunError, match="a has not saved a generation yet"):
            inherit(experiment, tmp_path / "a")
        with pytest.raises(RunError, match="nowhere does not exist"):
            inherit(experiment, "nowhere")


def test_a_damaged_population_is_refused_not_replaced_by_an_older_one(
    source: Path, tmp_path: Path
) -> None:
    import shutil

    shutil.copytree(source, tmp_path / "a")
    array = tmp_path / "a" / "checkpoints" / "6" / "arrays" / "0"
    array.write_bytes(array.read_bytes()[:100])
    with pytest.raises(RunError, match="checkpoints/6 is damaged"):
        inherit(GOING_ON, tmp_path / "a")


def test_older_runs_without_the_newer_settings_can_be_read(tmp_path: Path) -> None:
    import json

    path = tmp_path / "a"
    run_config.create(path, Config(experiment=TOY))
    data = json.loads((path / config.FILE).read_text())
    data["schema"] = config.WITHOUT_DIGEST
    del data["digest"], data["origin"]
    for name in ("start", "pruning"):
        del data["experiment"][name]
    for name in ("fine_trials", "fine_factor"):
        del data["experiment"]["goal"][name]
    (path / config.FILE).write_text(json.dumps(data))
    assert run_config.read(path) == Config(experiment=TOY)
