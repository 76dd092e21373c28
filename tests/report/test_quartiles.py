"""Tests of the median and quartiles of fitness over seeds."""

import numpy as np
from report import made

from mjxwalk.report import quartiles


def test_quartiles_of_four_runs_are_those_worked_out_by_hand() -> None:
    runs = [np.array([1.0, 10.0]), np.array([2.0, 20.0]), np.array([3.0, 30.0]), np.array([4.0])]
    found = quartiles.quartiles(runs)
    np.testing.assert_allclose(found[:, 0], [1.75, 2.5, 3.25])
    # The last run counts on with 4: of 4, 10, 20 and 30.
    np.testing.assert_allclose(found[:, 1], [8.5, 15.0, 22.5])


def test_what_has_no_value_is_left_out() -> None:
    found = quartiles.quartiles([np.array([np.nan, 1.0]), np.array([np.nan, 3.0])])
    assert np.isnan(found[:, 0]).all()
    np.testing.assert_allclose(found[:, 1], [1.5, 2.0, 2.5])


def test_one_run_has_no_quartiles_and_several_are_drawn_and_written() -> None:
    alone = [made.phase(fitness=(1.0, 2.0))]
    assert quartiles.picture({"fil": alone}) is None
    two = [made.phase(seed=1, fitness=(1.0, 2.0)), made.phase(seed=2, fitness=(3.0, 6.0))]
    drawn = quartiles.picture({"lpd": alone, "fil": two})
    assert drawn is not None and drawn.data is not None
    assert drawn.data["median_m"].tolist() == [2.0, 4.0]
    assert drawn.data["phase"].tolist() == ["fil", "fil"]
    assert "fil, 2 runs: in the last generation of all 4.0 m" in drawn.svg
