"""Runs and tournaments made up, with numbers that are easily worked out; nothing is evolved."""

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mjxwalk import experiments, runs
from mjxwalk.analysis.intervals import wilson
from mjxwalk.controllers import Weights
from mjxwalk.controllers.linear_reactive import INPUTS, NETWORKS, local_links
from mjxwalk.report.sources import Phase
from mjxwalk.runs import metrics
from mjxwalk.runs.metrics import Metrics
from mjxwalk.runs.result import Champion, Result
from mjxwalk.tournament import Condition, Tournament
from mjxwalk.tournament.results import AS_EVOLVED, HALF_STEP
from mjxwalk.walker import Walker


def condition(name: str, falls: int, **figures: Any) -> Condition:
    """Returns 200 trials of 20 m each."""
    interval = wilson(falls, 200)
    usual: dict[str, Any] = {
        "distance_mean_m": 20.0,
        "cost_of_transport": 0.25,
        "speed_m_s": 1.2,
        "step_length_m": 0.7,
        "double_stance": 0.12,
    }
    return Condition(
        name=name,
        trials=200,
        distance_sd_m=1.0,
        fall_rate=falls / 200,
        fall_rate_low=interval.low,
        fall_rate_high=interval.high,
        **(usual | figures),
    )


def tournament(falls: int = 10, **figures: Any) -> Tournament:
    """Returns one with as many falls of 200 trials, and twice as many at half the step."""
    return Tournament(
        entrants=50,
        newest_generation=20,
        winner_generation=18,
        screening_terrains=20,
        seed=0,
        engine="lanes",
        roughness_m=0.02,
        conditions=(
            condition(AS_EVOLVED, falls, **figures),
            condition(HALF_STEP, 2 * falls, **figures),
        ),
    )


def weights(links: dict[str, tuple[str, ...]] | None = None) -> Weights:
    """Returns weights of one where there is a link: the local ones, and others by network."""
    present = local_links().copy()
    for network, inputs in (links or {}).items():
        for name in inputs:
            present[NETWORKS.index(network), INPUTS.index(name)] = True
    rows: Any = present.astype(np.float32)
    blend_time: Any = np.float32(1.0)
    return Weights(initiation=rows, walking=rows, blend_time=blend_time, gains=None)


def phase(
    name: str = "fil",
    *,
    study: str = "solomon-2d",
    seed: int = 0,
    fitness: Sequence[float] = (1.0, 2.0, 4.0),
    finished: bool = True,
    held: Tournament | None = None,
    genotype: Weights | None = None,
    stopped_at: int = -1,
    folder: str = "runs/study",
    experiment: Any = None,
) -> Phase:
    """Returns a run of so many generations, of which the mean fitness is half of the best."""
    given = experiment or experiments.get(f"{study}/{name}")
    lines = [_line(number, value) for number, value in enumerate(fitness, 1)]
    path = Path(folder) / f"{name}-{seed}"
    walker = Walker(
        name=str(path),
        rank="winner" if held else "champion",
        experiment=given,
        genotype=weights() if genotype is None else genotype,
        generation=len(lines),
    )
    state = {"stopped_at": stopped_at, "age": len(lines), "finished": stopped_at >= 0}
    arrays = {f"strategy.{key}": np.asarray(value) for key, value in state.items()}
    arrays |= {"strategy.recent": np.array([1.8, 1.9, 2.0])}
    arrays |= {"strategy.reference": np.array([np.nan, 2.0, 2.0])}
    run = runs.Run(
        path=path,
        config={"seed": seed, "engine": "auto", "origin": None},
        manifest={"engine": "lanes", "mjxwalk": "0.1.0", "python": "3.12"},
        metrics=metrics.columns(lines),
        generations=[len(lines)],
        generation=len(lines),
        damaged={},
        arrays=arrays,
        result=_result(len(lines)) if finished else None,
        champion={},
    )
    return Phase(
        name=name,
        study=study,
        run=run,
        experiment=given,
        walker=walker,
        tournament=held,
        is_running=False,
    )


def changed(given: Phase, **changes: Any) -> Phase:
    """Returns the run with other settings of its experiment."""
    experiment = dataclasses.replace(given.experiment, **changes)
    return dataclasses.replace(given, experiment=experiment)


def _line(number: int, fitness: float) -> Metrics:
    return Metrics(
        generation=number,
        best_fitness=fitness,
        mean_fitness=fitness / 2,
        median_fitness=fitness / 2,
        best_distance_m=fitness,
        mean_distance_m=fitness / 2,
        median_distance_m=fitness / 2,
        fall_share=0.5,
        diverged_share=0.0,
        speed_m_s=1.0,
        cost_of_transport=0.3,
        physics_steps=1_000_000,
        steps_per_s=1e6,
        evaluate_s=40.0,
        compile_s=0.0,
        other_s=10.0,
        strategy={},
    )


def _result(generations: int) -> Result:
    champion = Champion(
        generation=generations,
        distance_m=10.0,
        fall_rate=0.1,
        speed_m_s=1.0,
        cost_of_transport=0.3,
        terrains=10,
    )
    return Result(champion=champion, generations=generations, wall_s=1.0, physics_steps=1)
