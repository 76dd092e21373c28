"""Tests of what a run shows, on a terminal and off one."""

import dataclasses
import io
from pathlib import Path

import msgspec
import pytest
import toy
from cart import Cart
from rich.console import Console

from mjxwalk import experiments
from mjxwalk.cli.progress import PlainProgress
from mjxwalk.cli.progress_live import LiveProgress
from mjxwalk.cli.progress_text import Clock, closing, count, duration, figures, opening
from mjxwalk.controllers import LinearFeedback
from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import Champion, Metrics, Result
from mjxwalk.runs.config import Origin

CONFIG = Config(experiment=toy.Toy(), seed=5)
EVALUATOR = toy.ToyEvaluator(toy.Toy(), "auto")
RESULT = Result(
    champion=Champion(
        generation=4,
        distance_m=12.345,
        fall_rate=0.2,
        speed_m_s=1.5,
        cost_of_transport=None,
        terrains=10,
    ),
    generations=6,
    wall_s=125.0,
    physics_steps=3_200_000,
)


def line(generation: int, evaluate_s: float = 2.0, compile_s: float = 0.0) -> Metrics:
    return Metrics(
        generation=generation,
        best_fitness=3.0,
        mean_fitness=2.0,
        median_fitness=1.0,
        best_distance_m=3.0,
        mean_distance_m=2.0,
        median_distance_m=1.0,
        fall_share=0.25,
        diverged_share=0.0,
        speed_m_s=1.5,
        cost_of_transport=None,
        physics_steps=1000,
        steps_per_s=12_345_678.0,
        evaluate_s=evaluate_s,
        compile_s=compile_s,
        other_s=0.0,
        strategy={},
    )


@pytest.mark.parametrize(
    ("seconds", "shown"),
    [
        (0.04, "0.0 s"),
        (9.96, "10.0 s"),
        (59.0, "59 s"),
        (59.7, "1 min 00 s"),
        (7325.0, "2 h 02 min"),
    ],
)
def test_durations_have_two_units(seconds: float, shown: str) -> None:
    assert duration(seconds) == shown


@pytest.mark.parametrize(
    ("number", "shown"), [(7, "7"), (1_500, "1.5 k"), (12_345_678.0, "12.3 M"), (2e9, "2 G")]
)
def test_counts_have_three_digits(number: float, shown: str) -> None:
    assert count(number) == shown


def test_time_left_is_by_the_typical_generation() -> None:
    clock = Clock(10)
    assert clock.left_s == 0
    for generation, seconds in ((1, 60.0), (2, 2.0), (3, 2.0)):
        clock.tick(line(generation, seconds))
    assert clock.left_s == 14.0


def test_a_figure_without_value_is_a_dash() -> None:
    assert dict(figures(line(1)))["cost of transport"] == "-"


def test_fitness_is_shown_where_it_is_not_the_distance() -> None:
    told = line(1)
    assert "fitness best/mean/median" not in dict(figures(told))
    told = msgspec.structs.replace(told, best_fitness=1234.5, median_fitness=None)
    assert dict(figures(told))["fitness best/mean/median"] == "1234.50/2.00/-"
    assert dict(figures(told))["distance best/mean/median"] == "3.00/2.00/1.00 m"


@pytest.mark.parametrize(
    ("fitness", "shown"),
    [(None, "12.35 m"), (12.345, "12.35 m"), (1234.5, "fitness 1234.50, 12.35 m")],
)
def test_the_end_tells_fitness_where_it_is_not_the_distance(
    fitness: float | None, shown: str
) -> None:
    champion = msgspec.structs.replace(RESULT.champion, fitness=fitness)
    told = closing(Path("a"), CONFIG, msgspec.structs.replace(RESULT, champion=champion))
    assert f"champion of generation 4: {shown}, 1.50 m/s" in told[1]


def test_the_end_of_a_gymnasium_task_points_to_verify_as_no_page_shows_it() -> None:
    pytest.importorskip("gymnasium")
    settings = Config(experiment=experiments.get("gymnasium/Hopper-v5"))
    assert closing(Path("a"), settings, RESULT)[-1] == "      mjxwalk verify a"
    assert closing(Path("a"), CONFIG, RESULT)[-1] == "      mjxwalk watch a"


def test_the_end_of_a_task_without_a_body_names_no_page() -> None:
    usual = experiments.get("planar-lpd")
    task = dataclasses.replace(usual, name="cart", env=Cart(), controller=LinearFeedback())
    assert closing(Path("a"), Config(experiment=task), RESULT)[-1] == "next: mjxwalk report a"


def test_off_a_terminal_there_is_a_line_for_each_second_and_the_last_generation(
    capsys: pytest.CaptureFixture[str],
) -> None:
    progress = PlainProgress()
    progress.start(Path("a"), CONFIG, EVALUATOR)
    for generation in range(1, 7):
        progress.generation(line(generation, compile_s=1.5 if generation == 1 else 0.0))
    progress.close()
    progress.finish(Path("a"), CONFIG, RESULT)
    shown = capsys.readouterr().out.splitlines()
    generations = [text.split(":")[0] for text in shown if text.startswith("generation")]
    assert generations == ["generation 1/6", "generation 6/6"]
    assert shown.count("compiled in 1.5 s") == 1
    assert any("distance best/mean/median 3.00/2.00/1.00 m, falls 25%" in text for text in shown)
    assert "evolved toy, seed 5: 6 generations, 3.2 M physics steps in 2 min 05 s" in shown
    assert any("12.35 m, 1.50 m/s" in text and "falls in 20% of 10" in text for text in shown)


def test_off_a_terminal_a_long_wait_for_the_first_generation_is_told_once(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mjxwalk.cli.progress.PATIENCE", 0.0)
    progress = PlainProgress()
    progress.start(Path("a"), CONFIG, EVALUATOR)
    told = ""
    while "compiling" not in told:
        told += capsys.readouterr().out
    progress.generation(line(1))
    progress.start(Path("a"), CONFIG, EVALUATOR)
    progress.close()
    assert told.count("compiling and evaluating the first generation ...") == 1


def test_the_opening_says_what_a_run_starts_from_and_when_it_ends() -> None:
    pruned = toy.STUDY.phase("pruned")
    settings = Config(experiment=pruned, origin=Origin(source="../2-near", generation=9))
    first, second, _ = opening(Path("a"), settings, EVALUATOR)
    assert "until pruning costs too much, at most 30 generations of 16 walkers" in first
    assert second == "starting from the population of ../2-near, generation 9"


def test_the_opening_names_the_body_that_a_file_gave() -> None:
    settings = Config(experiment=experiments.get("walk"))
    assert opening(Path("a"), settings, EVALUATOR)[0].startswith(
        "evolving walk with the body h1, seed "
    )
    experiment = settings.experiment
    unnamed = dataclasses.replace(
        experiment,
        env=dataclasses.replace(
            experiment.env, body=experiment.env.body.replace('<mujoco model="h1">', "<mujoco>")
        ),
    )
    told = opening(Path("a"), dataclasses.replace(settings, experiment=unnamed), EVALUATOR)
    assert "until 95 % of 64 trials end without a fall, at most 600 generations" in told[0]
    assert told[0].startswith("evolving walk, seed ")


def test_on_a_terminal_the_last_figures_stay() -> None:
    screen = io.StringIO()
    console = Console(file=screen, force_terminal=True, width=200, highlight=False)
    progress = LiveProgress(console)
    progress.start(Path("a[b]"), CONFIG, EVALUATOR)
    for generation in (1, 2):
        progress.generation(line(generation))
    progress.close()
    progress.close()
    progress.finish(Path("a[b]"), CONFIG, RESULT)
    shown = screen.getvalue()
    assert "generation 2/6" in shown
    assert "8.0 s left" in shown
    assert "12.3 M" in shown
    assert "in a[b]" in shown
