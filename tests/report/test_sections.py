"""Tests of a report's numbers, on runs that are made up."""

from typing import Any

import msgspec
import numpy as np
import pytest
from report.made import changed, condition, phase, tournament, weights

from mjxwalk.report import benchmarks, fitness, links, provenance_section, remarks, winners
from mjxwalk.report.parts import Picture, Section, Table
from mjxwalk.report.sources import Source


def tables(section: Section) -> dict[str, Table]:
    return {part.name: part for part in section.parts if isinstance(part, Table)}


def pictures(section: Section) -> dict[str, Picture]:
    return {part.name: part for part in section.parts if isinstance(part, Picture)}


def drawn(section: Section, name: str = "figure-4a") -> Any:
    """Returns the numbers that a picture shows."""
    return pictures(section)[name].data


def texts(table: Table) -> dict[str, list[str]]:
    return {
        row.head: [cell.text for cell in row.cells] for group in table.groups for row in group.rows
    }


def test_fitness_of_a_larger_budget_is_scaled_down() -> None:
    variants = {"lpd": [phase("lpd")], "fil": [phase("fil")]}
    data = drawn(fitness.section(variants))
    # LPD evolves with nine times the budget of FIL.
    assert data["fittest_m"].tolist() == pytest.approx([1 / 9, 2 / 9, 4 / 9, 1, 2, 4])
    assert data["phase"].tolist() == ["lpd"] * 3 + ["fil"] * 3
    assert data["factor"].tolist() == pytest.approx([1 / 9] * 3 + [1] * 3)
    caption = pictures(fitness.section(variants))["figure-4a"].caption
    assert "Fitness of lpd is times 0.11" in caption


def test_pruning_is_stretched_to_the_mean_length_and_ends_where_it_ended() -> None:
    first = phase("sil", fitness=(1, 2, 3, 4, 9, 9), stopped_at=4)
    second = phase("sil", fitness=(1, 4, 9, 9), stopped_at=2, seed=1)
    data = drawn(fitness.section({"sil": [first, second]}))
    assert data["phase"].tolist() == ["sil: pruning"] * 3 + ["after"] * 2
    # (1, 2, 3, 4) in three points is 1, 2.5, 4; (1, 4) is the same.
    assert data["fittest_m"].tolist() == pytest.approx([1, 2.5, 4, 9, 9])
    assert data["fittest_sd_m"].tolist() == pytest.approx([0] * 5)


def test_the_reduced_set_is_drawn_beside_all_links() -> None:
    reduced = phase("rsil", study="solomon-2d-rsil", fitness=(3, 5))
    given = {"lpd": [phase("lpd")], "fil": [phase("fil")], "rsil": [reduced]}
    section = fitness.section(given)
    assert set(drawn(section)["phase"]) == {"lpd", "fil"}
    assert drawn(section, "figure-4b")["fittest_m"].tolist() == [3, 5, 1, 2, 4]


def test_a_run_that_was_cut_short_counts_as_far_as_it_goes() -> None:
    given = {"fil": [phase(seed=0), phase(seed=1, fitness=(3.0,), finished=False)]}
    section = fitness.section(given)
    assert drawn(section)["fittest_m"].tolist() == [2, 2, 4]
    assert "ended after 1 to 3 generations" in pictures(section)["figure-4a"].caption


def test_falls_are_counted_by_trials_and_by_distance() -> None:
    given = {"fil": [phase(held=tournament(10)), phase(seed=1, held=tournament(30))]}
    table = tables(winners.section(given))["winners"]
    # 40 of 400 trials of 20 m: 40 falls in 8,000 m. The interval is scipy's Wilson interval.
    row = texts(table)["as evolved"]
    assert row[:5] == ["2", "400", "20.00 ± 0.00", "10.0 % (7.4 to 13.3)", "0.50"]
    assert row[5:] == ["0.250 ± 0.000", "1.20 ± 0.00", "0.700 ± 0.000", "12.0 %"]
    assert texts(table)["half the time step"][3].startswith("20.0 %")
    assert table.data["fall_rate"].tolist() == [0.1, 0.2]


def test_winners_are_told_one_by_one_where_there_are_several() -> None:
    given = {"fil": [phase(held=tournament(10)), phase(seed=1, held=tournament(30))]}
    table = tables(winners.section(given))["winners-by-run"]
    assert [row[3] for row in texts(table).values()] == [
        "5.0 % (2.7 to 9.0)",
        "15.0 % (10.7 to 20.6)",
    ]
    assert len(table.data) == 4
    assert "winners-by-run" not in tables(winners.section({"fil": [phase()]}))


def test_without_a_tournament_there_are_the_champions_own_trials() -> None:
    table = tables(winners.section({"fil": [phase()]}))["winners"]
    assert texts(table)["at the end of the run"][1:3] == ["10", "10.00"]
    cut = tables(winners.section({"fil": [phase(finished=False)]}))["winners"]
    assert list(texts(cut)) == ["no tournament yet"]


def test_walkers_that_get_nowhere_have_no_falls_by_distance() -> None:
    nowhere = condition("as evolved", 200, distance_mean_m=-0.1, cost_of_transport=None)
    tried = winners.gathered([nowhere])
    assert np.isnan(tried.falls_per_100_m)
    assert np.isnan(tried.figures["cost_of_transport"].mean)


def test_table_4_has_what_is_left_of_the_papers_numbers() -> None:
    given = {name: [phase(name, held=tournament(10))] for name in ("lpd", "fil")}
    table = tables(benchmarks.section(given))["table-4"]
    assert texts(table)["lpd"] == ["1", "5.0 % (2.7 to 9.0)", "5.0 %", "7.3 %", "0.250", "lost"]
    assert texts(table)["fil"][3] == "lost"
    assert benchmarks.section({"fil": [phase(finished=False)]}).parts == ()


def test_table_3_counts_links_and_has_the_papers_shares() -> None:
    both = {"torso": ("inter-leg", "stance thigh"), "stance ankle": ("torso",)}
    one = {"torso": ("inter-leg",)}
    given = [
        phase("sil", genotype=weights(both), stopped_at=2),
        phase("sil", genotype=weights(one), seed=1, stopped_at=3),
    ]
    found = tables(links.section({"fil": [phase()], "sil": given}))
    summary = texts(found["table-3-sil-networks"])
    # 3 of 2 x 13 links, and 1 of them; one of the torso's is in both winners.
    assert summary["torso"] == ["12 %", "61 %", "1", "4"]
    assert summary["stance ankle"] == ["4 %", "66 %", "0", "7"]
    assert summary["swing knee"] == ["0 %", "8 %", "0", "0"]
    counted = texts(found["table-3-sil"])
    assert counted["inter-leg"] == ["2", "always", "0", "0", "0", "0"]
    assert counted["torso"] == ["always", "0", "0", "0", "1", "0"]
    marked = [
        (row.head, place)
        for group in found["table-3-sil"].groups
        for row in group.rows
        for place, cell in enumerate(row.cells)
        if cell.is_marked
    ]
    assert marked == [("inter-leg", 0)]
    course = texts(found["pruning-sil"])
    assert course["generations until removing ended"] == ["2 (2 to 3)", "564"]
    assert course["non-local links left, of 78"] == ["2 (1 to 3)", "31"]
    # The median of 1.8, 1.9 and 2.0, of 2.0.
    assert (
        course["fitness of the latest elites, of that before pruning"][0] == "0.95 (0.95 to 0.95)"
    )


def test_without_pruning_there_is_no_table_3() -> None:
    section = links.section({"fil": [phase()]})
    assert not section.parts
    assert "none of these runs prunes" in section.texts[0]


def test_times_are_told_in_words() -> None:
    assert provenance_section.duration(12.34) == "12.3 s"
    assert provenance_section.duration(75.0) == "1 min 15 s"
    assert provenance_section.duration(7260.0) == "2 h 1 min"
    assert provenance_section.wall_time(phase()) == 150.0


def test_what_is_short_missing_or_doubtful_is_told() -> None:
    held = tournament(0)
    conditions = (held.conditions[0], condition("half the time step", 150))
    worse = msgspec.structs.replace(held, conditions=conditions)
    cut = phase(seed=1, finished=False)
    given = [phase(held=worse), cut, phase(held=worse)]
    read = [Source(path=each.run.path, study=None, phases=(each,)) for each in given]
    read[1] = Source(path=cut.run.path, study=None, phases=(cut,), missing=("sil",))
    told = {remark.text: list(remark.items) for remark in remarks.find(read, {"fil": given})}
    found = "\n".join(f"{text}{items}" for text, items in told.items())
    assert "fil-1: cut short at 3 of 3000" in found
    assert "mjxwalk resume runs/study/fil-1" in found
    assert "mjxwalk tournament runs/study/fil-1" in found
    assert "fil-1: sil" in found
    assert "the gait is an artefact of its time step" in found
    assert "runs/study/fil-0 and runs/study/fil-0: seed 0" in found
    assert "One run" not in found


def test_what_tournaments_of_many_runs_found_is_counted() -> None:
    def held(falls: int) -> Any:
        conditions = (condition("as evolved", 10), condition("half the time step", falls))
        return msgspec.structs.replace(tournament(), conditions=conditions)

    falls = [150, 160, 10, 12, 10]  # of 200
    given = [phase(seed=seed, held=held(count)) for seed, count in enumerate(falls)]
    read = [Source(path=each.run.path, study=None, phases=(each,)) for each in given]
    told = {remark.text: remark.items for remark in remarks.find(read, {"fil": given})}
    ((line, _),) = told["What the tournaments found:"]
    assert line == (
        "fil, 2 of 5 winners: another gait at half the time step, where 5.0 to 80.0 % fall in "
        "place of 5.0 to 5.0 %"
    )


def test_commands_are_quoted_for_the_shell() -> None:
    odd = phase(folder="my runs/$(ls)", finished=False)
    read = [Source(path=odd.run.path, study=None, phases=(odd,))]
    items = [item for remark in remarks.find(read, {"fil": [odd]}) for item in remark.items]
    commands = [command for _, command in items]
    assert "mjxwalk resume 'my runs/$(ls)/fil-0'" in commands


def test_a_population_of_other_settings_is_told_in_the_table_of_runs() -> None:
    small = changed(phase(), population_size=12)
    section = provenance_section.section([Source(path=small.run.path, study=None, phases=(small,))])
    assert texts(tables(section)["runs"])["runs/study/fil-0"][2] == "12"
    assert section.commands[0].startswith("mjxwalk evolve solomon-2d/fil --seed 0 --set ")
    assert "population_size=12" in section.commands[0]
