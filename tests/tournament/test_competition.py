"""Tests of the tournament's rule, on walkers of the toy whose figures are known."""

from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
import toy

from mjxwalk import cli, evaluation, tournament, walkers
from mjxwalk.envs import Trials
from mjxwalk.evolution.generation import outer_keys
from mjxwalk.rollout import Outcome
from mjxwalk.tournament import competition
from mjxwalk.tournament.entrants import Entrants
from mjxwalk.tournament.results import AS_EVOLVED

TOY = toy.Toy(env=toy.World(terrain=toy.Ground(roughness=0.1)))


@pytest.fixture(autouse=True)
def grounds(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Returns all terrains that are evaluated on, a table each time."""
    seen: list[Any] = []

    class Recording(toy.ToyEvaluator):
        def evaluate(self, population: Any, trials: Trials) -> Outcome:
            seen.append(np.asarray(trials.heights))
            return super().evaluate(population, trials)

    toy.install(monkeypatch)
    monkeypatch.setattr(evaluation, "make_evaluator", Recording)
    return seen


def entrants(*off: float) -> Entrants:
    """Returns walkers whose bias is so far from the best one, of generations 11, 12, ..."""
    gain = np.ones((len(off), 2, 3), np.float32)
    return Entrants(
        name="some",
        experiment=TOY,
        genotypes=toy.Genotype(gain, np.float32(1) + np.array(off, np.float32)),  # type: ignore[arg-type]
        generations=np.arange(len(off)) + 11,
    )


def test_the_entrant_with_the_best_mean_wins() -> None:
    held = tournament.compete(entrants(0.5, 0.1, -0.3), screening=3, terrains=5)
    assert (held.winner_generation, held.newest_generation) == (12, 13)
    assert (held.entrants, held.screening_terrains, held.engine) == (3, 3, "mjx")
    assert held.roughness_m == 0.1


def test_nan_never_wins_and_the_newest_of_equals_does() -> None:
    fitness = np.array([[9.0, np.nan], [1.0, 2.0], [2.0, 1.0], [0.0, 0.0]])
    assert competition.winner(fitness) == 2
    assert competition.winner(np.full((2, 1), np.nan)) == 1


def test_figures_are_those_of_the_trials(grounds: list[Any]) -> None:
    held = tournament.compete(entrants(2.2, 2.3), seed=3, screening=2, terrains=600)
    figures = held.conditions[0]
    off = 6 * np.concatenate(grounds[1:3])[:, 0].astype(np.float64) ** 2 + 2.2**2
    fell = int((off > 5).sum())
    assert 0 < fell < 600
    assert (figures.name, figures.trials) == (AS_EVOLVED, 600)
    # float32 trials
    assert figures.distance_mean_m == pytest.approx((10 - off).mean(), rel=1e-5)
    assert figures.distance_sd_m == pytest.approx(off.std(), rel=1e-4)
    assert figures.fall_rate == fell / 600
    assert figures.fall_rate_low < figures.fall_rate < figures.fall_rate_high
    assert figures.speed_m_s == pytest.approx((10 - off[off <= 5]).mean() / 2, rel=1e-5)
    cost = 40.0 / (10.0 * (10 - off).mean())
    assert figures.cost_of_transport == pytest.approx(cost, rel=1e-5)
    assert figures.step_length_m is None


def test_a_walker_that_always_falls_has_no_speed() -> None:
    figures = tournament.compete(entrants(4.0), terrains=4).conditions[0]
    assert figures.fall_rate == 1.0
    assert figures.speed_m_s is None
    assert figures.cost_of_transport is None  # and got nowhere


def test_a_lone_entrant_wins_untried() -> None:
    held = tournament.compete(entrants(0.0), terrains=4)
    assert (held.winner_generation, held.screening_terrains) == (11, 0)


def test_terrains_of_the_run_of_screening_and_of_reporting_have_nothing_in_common(
    grounds: list[Any], tmp_path: Path
) -> None:
    assert cli.main(["evolve", "--seed", "0", "--out", str(tmp_path / "a")]) == 0
    run = np.concatenate(grounds)
    grounds.clear()
    tournament.compete(walkers.entrants(tmp_path / "a"), seed=0, screening=7, terrains=11)
    held = np.concatenate(grounds[:2])
    assert grounds[0].shape[0] == 7
    # The same terrains under all conditions, so that figures can be compared.
    for others in grounds[2:]:
        np.testing.assert_array_equal(others[:, :1], grounds[1][: len(others)])
    assert len(np.unique(held)) == 7 + 11
    assert not np.intersect1d(run, held).size


def test_no_run_of_the_same_seed_draws_from_a_key_of_the_tournament() -> None:
    key = jax.random.key(5)
    generations = jax.vmap(lambda g: jax.random.fold_in(key, g))(np.arange(5000))
    drawn = jax.vmap(lambda k: jax.random.split(k, 4))(generations)
    ours = np.array([jax.random.key_data(each) for each in competition.draw_keys(5)])
    theirs = np.array([*jax.random.key_data(drawn).reshape(-1, 2)])
    outer = np.array([jax.random.key_data(each) for each in outer_keys(key)])
    every = {tuple(row) for row in np.concatenate([theirs, outer]).tolist()}
    assert len({tuple(row) for row in ours.tolist()} - every) == 3


def test_the_same_seed_gives_the_same_tournament_and_another_gives_another() -> None:
    first, same, other = (
        tournament.compete(entrants(0.5, 0.1), seed=seed, screening=2, terrains=5)
        for seed in (1, 1, 2)
    )
    assert first == same
    assert first.conditions[0].distance_mean_m != other.conditions[0].distance_mean_m


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"terrains": 0}, "terrains must be at least 1, got 0"),
        ({"screening": -1}, "screening must be at least 1, got -1"),
        ({"seed": -1}, "seed must be from 0 to 4294967295, got -1"),
        ({"engine": "warp"}, "engine must be one of auto, mjx, got 'warp'"),
    ],
)
def test_wrong_numbers_are_refused(changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        tournament.compete(entrants(0.1), **changes)
