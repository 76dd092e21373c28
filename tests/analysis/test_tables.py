"""Tests of the paper's tables."""

import numpy as np
from analysis.walking import recording, walk

from mjxwalk.analysis import gait, tables
from mjxwalk.analysis.tables import Benchmark
from mjxwalk.controllers.linear_reactive import NETWORKS, local_links
from mjxwalk.envs import Planar7


def gait_of(stance: int) -> gait.Gait:
    made = recording([walk(stance=stance)] * 2 + [walk(600, stance=90)], fell=[False, False, True])
    return gait.measure_gait(made, Planar7())


def test_table_3_tells_what_each_network_keeps() -> None:
    nothing, everything = local_links(), np.ones((6, 16), bool)
    table = tables.table_3_summary(np.stack([nothing, everything]), threshold=0.5)
    assert table.index.tolist() == list(NETWORKS)
    assert np.all(table["kept"] == 0.5) and np.all(table["reduced_links"] == 13)
    # Section 3.2 names the networks in this order.
    paper = table.loc[["torso", "inter-leg", "stance ankle", "swing knee", "stance knee",
                       "swing ankle"], "paper_kept"]  # fmt: skip
    assert paper.tolist() == [0.61, 0.51, 0.66, 0.08, 0.18, 0.32]


def test_table_4_has_falls_with_their_interval() -> None:
    table = tables.table_4(
        {"lpd": [Benchmark(1000, 73, 0.4), Benchmark(1000, 127, 0.6)], "fil": [], "mine": []}
    )
    row = table.loc["lpd"]
    np.testing.assert_allclose(row["fall_rate"], 0.1)
    # By hand: (0.1 + 0.00096 -+ 1.96 sqrt(0.09 / 2000 + 2.4e-7)) / 1.00192
    np.testing.assert_allclose(row["fall_rate_low"], 0.08760, atol=2e-5)
    np.testing.assert_allclose(row["fall_rate_high"], 0.11392, atol=2e-5)
    assert row["lowest_fall_rate"] == row["paper_lowest_fall_rate"] == 0.073
    np.testing.assert_allclose(row["cost_of_transport"], 0.5)
    np.testing.assert_allclose(row["cost_of_transport_sd"], np.sqrt(0.02))
    assert np.isnan(table.loc["fil", "fall_rate"]) and table.loc["fil", "runs"] == 0
    assert table.loc[["fil", "mine"], "paper_cost_of_transport"].isna().all()


def test_table_4_knows_walkers_that_get_nowhere() -> None:
    row = tables.table_4({"lpd": [Benchmark(10, 10, None)]}).loc["lpd"]
    assert row["fall_rate"] == row["fall_rate_high"] == 1.0
    assert np.isnan(row["cost_of_transport"])


def test_table_5_has_deviations_between_winners_beside_a_human() -> None:
    table = tables.table_5({"fil": [gait_of(72), gait_of(78)]})
    row = table.loc["fil"]
    assert (row["runs"], row["trials"], row["falls"], row["strides"]) == (2, 6, 2, 28)
    np.testing.assert_allclose(row["double_stance"], 0.25, rtol=1e-3)
    np.testing.assert_allclose(row["double_stance_sd"], 0.1 / np.sqrt(2), rtol=1e-2)
    assert table.loc["human", "speed_m_s"] == 1.24 and table.loc["human", "speed_m_s_sd"] == 0.1
    assert table.loc["human, as in the paper", "double_stance"] == 0.2


def test_table_5_of_one_winner_has_deviations_between_its_trials() -> None:
    row = tables.table_5({"fil": [gait_of(72)]}).loc["fil"]
    np.testing.assert_allclose(row["double_stance_sd"], 0.0, atol=1e-9)
    assert np.isnan(tables.table_5({"fil": []}).loc["fil", "speed_m_s"])
    assert tables.table_5({}).index.tolist() == ["human", "human, as in the paper"]


def test_whole_numbers_stay_whole_in_the_csv() -> None:
    rows = tables.table_5({"fil": [gait_of(72)]}).to_csv().splitlines()
    assert rows[1].startswith("fil,1,3,1,14,") and rows[2].startswith("human,,,,,1.24,0.1,")
