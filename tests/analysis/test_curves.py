"""Tests of averaging fitness over runs."""

import numpy as np

from mjxwalk.analysis import curves


def test_runs_of_one_length_are_averaged_generation_by_generation() -> None:
    runs = np.random.default_rng(0).normal(size=(7, 20))
    curve = curves.average(list(runs))
    np.testing.assert_allclose(curve.mean, runs.mean(axis=0))
    np.testing.assert_allclose(curve.sd, runs.std(axis=0, ddof=1))


def test_a_run_that_was_cut_short_counts_as_far_as_it_goes() -> None:
    curve = curves.average([np.array([1.0, 3.0, np.nan]), np.array([3.0])])
    np.testing.assert_allclose(curve.mean, [2.0, 3.0, np.nan])
    np.testing.assert_allclose(curve.sd, [np.sqrt(2.0), np.nan, np.nan])


def test_one_run_has_no_deviation_and_none_has_no_curve() -> None:
    assert np.isnan(curves.average([np.arange(3.0)]).sd).all()
    assert len(curves.average([]).mean) == 0
    assert len(curves.average_phase("none", [], stretch=True)) == 0


def test_pruning_is_stretched_to_its_mean_length() -> None:
    short, long = np.linspace(0.0, 10.0, 11), np.linspace(0.0, 10.0, 31)
    made = curves.stretched([short, long])
    assert [len(each) for each in made] == [21, 21]
    # Straight lines stay straight, and ends stay ends.
    for each in made:
        np.testing.assert_allclose(each, np.linspace(0.0, 10.0, 21))


def test_stretching_an_empty_series_leaves_it_out() -> None:
    assert len(curves.stretched([np.zeros(0), np.ones(4)])) == 1
    np.testing.assert_allclose(curves.stretched([np.array([2.0])], length=3)[0], 2.0)


def test_fitness_of_a_phase_is_scaled() -> None:
    metrics = {"best_fitness": np.array([3.0, 6.0]), "mean_fitness": np.array([1.5, 3.0])}
    phase = curves.average_phase("lpd", [metrics, metrics], scale=1 / 3)
    np.testing.assert_allclose(phase.best.mean, [1.0, 2.0])
    np.testing.assert_allclose(phase.mean.mean, [0.5, 1.0])
    assert (phase.num_runs, len(phase)) == (2, 2)


def test_a_pruned_run_is_split_where_pruning_ended() -> None:
    metrics = {"generation": np.arange(1, 14), "best_fitness": np.arange(13.0)}
    ended = {"age": np.int32(13), "stopped_at": np.int32(3)}
    assert curves.settled_generations(ended) == 10
    assert curves.settled_generations(ended | {"stopped_at": np.int32(-1)}) == 0
    pruning, after = curves.split_pruning(metrics, 10)
    np.testing.assert_array_equal(pruning["generation"], [1, 2, 3])
    np.testing.assert_array_equal(after["best_fitness"], np.arange(3.0, 13.0))
    whole, nothing = curves.split_pruning(metrics, 0)
    assert len(whole["generation"]) == 13 and len(nothing["generation"]) == 0
