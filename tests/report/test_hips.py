"""Tests of the page on a hip-powered biped, on trials that are made up."""

import dataclasses
from types import SimpleNamespace

import numpy as np
from report.made import phase

from mjxwalk import experiments
from mjxwalk.analysis import hip_figures
from mjxwalk.analysis.hip_figures import Course
from mjxwalk.envs import Reil
from mjxwalk.envs.bodies.reil_body import HIPS
from mjxwalk.replay import Recording
from mjxwalk.report import hips
from mjxwalk.report.parts import Picture
from mjxwalk.report.sources import Phase, Source


def assisted_and_not() -> dict[str, list[Phase]]:
    study = experiments.get_study("reil")
    return {
        name: [dataclasses.replace(phase(), name=name, experiment=experiment)]
        for name, experiment in study.phases[:2]
    }


def test_assisted_runs_are_figure_9_and_with_what_follows_figure_10() -> None:
    variants = assisted_and_not()
    drawn = {part.name: part for part in hips.fitness_section(variants).parts}
    assert list(drawn) == ["figure-9", "figure-10"]
    nine, ten = (part.data for part in drawn.values())
    assert nine is not None and ten is not None
    assert set(nine["phase"]) == {"assisted"}
    assert ten["phase"].tolist() == ["assisted"] * 3 + ["unassisted"] * 3
    # One in the other's metres: both trials may cost as much.
    assert ten["fittest_m"].tolist() == [1.0, 2.0, 4.0] * 2


def test_runs_that_never_had_assistance_are_figure_11() -> None:
    alone = {"reil-unassisted": assisted_and_not()["unassisted"]}
    (part,) = hips.fitness_section(alone).parts
    assert isinstance(part, Picture) and part.caption.startswith("Figure 11.")


def made_up(frames: int = 11) -> Recording:
    """Returns a trial that ends at frame 8 of those, 1 s each; hips follow what they are asked."""
    at = np.minimum(np.arange(frames), 8)
    qpos = np.zeros((frames, 1, 14))
    target = np.stack([0.1 * at, -0.1 * at], axis=1)[:, None]
    qpos[:, :, HIPS] = target - 0.05
    qpos[:, 0, 8], qpos[:, 0, 12] = 0.2 * at, 0.3 * at  # knees
    done = (np.arange(frames) >= 8)[:, None]
    states = SimpleNamespace(qpos=qpos, own=SimpleNamespace(target=target))
    return Recording(at[:, None].astype(np.float32), done, states)


def test_a_course_is_that_of_hips_and_knees_from_the_first_step_to_the_trials_end() -> None:
    shown = hip_figures.course(made_up(), Reil().anatomy)
    np.testing.assert_array_equal(shown.time, np.arange(1, 9))
    np.testing.assert_allclose(shown.desired - shown.hip, 0.05)
    np.testing.assert_allclose(shown.knee[-1], [1.6, 2.4])
    np.testing.assert_array_equal(shown.time[shown.settled], np.arange(4, 9))


def test_a_trial_that_ends_early_is_shown_whole() -> None:
    short = Course(*(part[:2] for part in hip_figures.course(made_up(), Reil().anatomy)))
    assert short.settled.all()


def test_each_figure_shows_the_angles_that_it_names() -> None:
    shown = hip_figures.course(made_up(), Reil().anatomy)
    over_time = hip_figures.angles_over_time(shown, seconds=5.0)
    for leg, axis in enumerate(over_time.axes):
        desired, actual = (line.get_ydata() for line in axis.lines)
        np.testing.assert_array_equal(desired, shown.desired[:5, leg])
        np.testing.assert_array_equal(actual, shown.hip[:5, leg])
    pairs = {
        hip_figures.locking: [(shown.desired[:, 0], shown.hip[:, 0])],
        hip_figures.attractors: [shown.desired.T, shown.hip.T],
        hip_figures.limit_cycle: [(shown.hip[:, 0], shown.knee[:, 0])],
    }
    for draw, panels in pairs.items():
        for axis, (x, y) in zip(draw(shown).axes, panels, strict=True):
            whole, settled = axis.lines
            np.testing.assert_array_equal(whole.get_xdata(), x)
            np.testing.assert_array_equal(whole.get_ydata(), y)
            np.testing.assert_array_equal(settled.get_ydata(), y[3:])


def test_hip_powered_bodies_are_known_by_their_motors() -> None:
    powered, other = assisted_and_not()["assisted"][0], phase()
    for shown, is_powered in ((powered, True), (other, False)):
        source = Source(path=shown.run.path, study=None, phases=(shown,))
        assert hips.is_hip_powered(source) == is_powered
