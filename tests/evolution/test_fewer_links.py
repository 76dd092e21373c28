"""Runs on disk whose links come and go: stopped and resumed, they lose and grow the same ones."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import toy
from cart import Cart

from mjxwalk import evaluation, evolution, runs
from mjxwalk.controllers import Mlp
from mjxwalk.evolution.recorder import RunRecorder
from mjxwalk.experiments import run_config
from mjxwalk.experiments.experiment import Experiment, StrategyChoice
from mjxwalk.experiments.pruning import Pruning
from mjxwalk.experiments.rewiring import Rewiring
from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import Interrupted, Metrics
from mjxwalk.runs.trees import flatten

LAST = 6  # generation

PLAIN = Experiment(
    name="cart",
    env=Cart(),
    controller=Mlp(hidden=(5,), clock=False),
    strategy=StrategyChoice(name="snes", options={"sigma": 0.3}),
    population_size=6,
    generations=LAST,
    terrains_per_evaluation=2,
)
REWIRED = dataclasses.replace(PLAIN, rewiring=Rewiring(every=1, fraction=0.3, density=0.5))
PRUNED = dataclasses.replace(PLAIN, pruning=Pruning(every=1, floor=1e-6, reference=1, window=1))


class Watcher(toy.Silent):
    """Knows which generations are done."""

    def __init__(self) -> None:
        super().__init__()
        self.done: list[int] = []

    def generation(self, line: Metrics, /) -> None:
        self.done.append(line.generation)


def run(path: Path, experiment: Experiment, stop_after: int | None = None) -> None:
    """Evolves in a folder, or goes on there, by an evaluator of its own as a new process has."""
    settings, watcher = Config(experiment=experiment, keep=LAST), Watcher()
    if not path.exists():
        run_config.create(path, settings)
    with RunRecorder(path, settings, watcher) as recorder:
        evaluator = evaluation.make_evaluator(experiment, "mjx")
        evolution.evolve(settings, evaluator, recorder, stopping=lambda: stop_after in watcher.done)


def links_of(experiment: Experiment, path: Path, generation: int) -> np.ndarray:
    """Returns which links some walker of a generation has, a number for each weight."""
    links = flatten(experiment.controller.prunable())
    population = runs.load(path, generation).population
    there = [(population[name] != 0).any(0)[np.asarray(links[name]) >= 0] for name in sorted(links)]
    return np.concatenate(there)


@pytest.mark.parametrize("experiment", [REWIRED, PRUNED], ids=["rewired", "pruned"])
def test_a_stopped_run_resumes_to_the_same_bits(experiment: Experiment, tmp_path: Path) -> None:
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"
    run(whole, experiment)
    with pytest.raises(Interrupted, match="after generation 3"):
        run(stopped, experiment, stop_after=3)
    assert runs.load(stopped).generation == 3
    run(stopped, experiment)

    sets = [links_of(experiment, whole, generation) for generation in range(1, LAST + 1)]
    # Links go before the stop and after it, so that what is left of them matters.
    assert sets[2].sum() < sets[0].sum()
    assert (sets[5] != sets[2]).any()
    for generation in (3, LAST):
        one, other = (runs.load(path, generation).arrays for path in (whole, stopped))
        assert list(one) == list(other)
        for name, array in one.items():
            assert array.tobytes() == other[name].tobytes(), name
    assert (whole / "champion.npz").read_bytes() == (stopped / "champion.npz").read_bytes()


def test_rewired_links_grow_again_after_a_stop(tmp_path: Path) -> None:
    path = tmp_path / "run"
    with pytest.raises(Interrupted):
        run(path, REWIRED, stop_after=4)
    run(path, REWIRED)
    sets = [links_of(REWIRED, path, generation) for generation in range(4, LAST + 1)]
    assert any((after & ~before).any() for before, after in zip(sets[:-1], sets[1:], strict=True))
