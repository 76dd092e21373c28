"""What runs with normalised senses take over from others."""

import dataclasses
import shutil
from collections.abc import Generator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cart import Cart

from mjxwalk import cli, experiments, runs, walkers
from mjxwalk.controllers import LinearFeedback, Mlp
from mjxwalk.experiments import registry
from mjxwalk.experiments.experiment import Experiment, StrategyChoice
from mjxwalk.runs import files

EXPERIMENT = Experiment(
    name="cart",
    env=Cart(),
    controller=LinearFeedback(normalise=True),
    strategy=StrategyChoice(name="snes", options={"sigma": 0.3}),
    population_size=6,
    generations=2,
    terrains_per_evaluation=2,
)
PLAIN = dataclasses.replace(EXPERIMENT, name="plain", controller=LinearFeedback())
OTHER = dataclasses.replace(EXPERIMENT, name="other", controller=Mlp(normalise=True))


@pytest.fixture(autouse=True, scope="module")
def _registered() -> Generator[None]:  # pyright: ignore
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(registry, "_REGISTERED", {})
        for experiment in (EXPERIMENT, PLAIN, OTHER):
            experiments.register(experiment)
        yield


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run."""
    path = tmp_path_factory.mktemp("runs") / "source"
    assert cli.main(["evolve", "cart", "--out", str(path)]) == 0
    return path


def gone_on(source: Path, start: str) -> Path:
    """Returns a run that started from another one."""
    path = source.parent / start
    if path.exists():
        return path
    args = ["--from", str(source), "--set", f"start={start}", "--out", str(path)]
    assert cli.main(["evolve", "cart", *args]) == 0
    return path


def first(path: Path) -> Any:
    """Returns the population of a run's first generation, by leaf."""
    return runs.load(path, 1).population


def test_a_population_goes_on_with_what_its_run_sensed(source: Path) -> None:
    path, before = gone_on(source, "population"), runs.load(source)
    sensed = before.part("sensed")
    assert (first(path)["senses.num"] == np.float32(sensed["num"])).all()
    assert (first(path)["senses.mean"] == sensed["mean"].astype(np.float32)).all()
    num = runs.load(path, 1).part("sensed")["num"]
    assert num == sensed["num"] * 3 / 2  # every trial of a cart is as long


def test_a_population_that_was_stopped_goes_on_to_the_same_bits(source: Path) -> None:
    path = gone_on(source, "population")
    stopped = path.parent / "stopped"
    shutil.copytree(path, stopped)
    for name in ("result.json", "champion.npz", "checkpoints/1", "checkpoints/2", "metrics.jsonl"):
        files.remove(stopped, name)
    assert cli.main(["resume", str(stopped)]) == 0
    for name, array in runs.load(path).arrays.items():
        assert array.tobytes() == runs.load(stopped).arrays[name].tobytes()


@pytest.mark.parametrize("start", ["winner", "mean"])
def test_walkers_go_on_with_the_senses_as_their_ancestor_knew_them(
    source: Path, start: str
) -> None:
    path = gone_on(source, start)
    known: Any = walkers.best(source).genotype.senses
    if start == "mean":
        known = known._make(
            runs.load(source).population[f"senses.{name}"][0] for name in known._fields
        )
    for name, leaf in known._asdict().items():
        assert (first(path)[f"senses.{name}"] == leaf).all()


def test_a_source_whose_senses_are_not_normalised_is_one_sentence(
    source: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, complaint in (
        ("plain", "evolved with controller.normalise=true and this experiment has false"),
        ("other", "holds the weights of another controller"),
    ):
        args = ["evolve", name, "--from", str(source), "--out", str(source.parent / "not")]
        assert cli.main(args) == 2
        assert complaint in capsys.readouterr().err
