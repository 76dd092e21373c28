"""Tests of `mjxwalk verify`: C MuJoCo agrees with the engines, and tells when they err."""

import dataclasses
import json
import re
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import msgspec
import numpy as np
import pytest
import toy

from mjxwalk import cli, walkers
from mjxwalk.cli.verify import DISAGREES
from mjxwalk.envs import Planar7, RandomWalk, SerpentineWalk, SoftContact, Terrain
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.rollout import Outcome
from mjxwalk.verify import agreement, bodies, comparing, laws, trials
from mjxwalk.verify.agreement import Agreement
from mjxwalk.walker import Walker


def shorter(name: str, **rules: Any) -> Walker:
    """Returns a walker of the zoo whose trials end early."""
    walker = walkers.best(f"zoo:{name}")
    tried = walker.experiment.tried()
    env = dataclasses.replace(tried.env, **rules)
    return dataclasses.replace(walker, experiment=dataclasses.replace(tried, env=env))


@pytest.fixture(scope="module")
def planar() -> Agreement:
    """Returns the first second and a half of the planar walker of the zoo, compared."""
    return comparing.verify(
        shorter("planar-lpd", max_time=1.5), engine="lanes", terrains=3, seed=1, say=print
    )


def check_alike(found: Agreement) -> None:
    # For a second and a half float32 follows float64 step by step; a millimetre is 1e-3 of it.
    np.testing.assert_allclose(found.engine.distance_m, found.reference.distance_m, atol=1e-3)
    cost = found.reference.cost_of_transport
    assert found.engine.cost_of_transport == pytest.approx(cost, rel=5e-3)
    assert found.agrees and found.reference.fell == (False,) * 3
    assert min(found.reference.distance_m) > 0.5


def test_the_planar_walker_walks_alike_in_c_mujoco(planar: Agreement) -> None:
    check_alike(planar)


@pytest.mark.slow
def test_the_spatial_walker_walks_alike_in_c_mujoco() -> None:
    walker = shorter("flame-robust", max_time=1.5)
    check_alike(comparing.verify(walker, engine="lanes", terrains=3, seed=1, say=print))


@pytest.mark.slow
@pytest.mark.parametrize("rules", [{"min_hip_height": 0.91}, {"max_pitch": 0.03}])
def test_falls_come_at_the_same_step(rules: dict[str, float]) -> None:
    walker = shorter("planar-lpd", max_time=1.0, **rules)
    found = comparing.verify(walker, engine="lanes", terrains=1, seed=2, say=print)
    assert found.reference.fell == found.engine.fell == (True,)
    # Where a threshold is met on the flat of a curve, rounding moves it by a few steps.
    np.testing.assert_allclose(found.engine.duration_s, found.reference.duration_s, atol=5e-3)
    assert found.reference.duration_s[0] < 0.9


def in_c_mujoco(**rules: Any) -> Outcome:
    walker = shorter("planar-lpd", **({"max_time": 1.0} | rules))
    env = walker.experiment.env
    level = np.zeros((1, env.terrain.num_nodes))
    return trials.run(env, walker.experiment.controller, walker.genotype, level)


def test_a_trial_ends_where_its_rules_say() -> None:
    late = in_c_mujoco(max_time=0.1)
    assert (late.duration, late.steps, late.fell) == (pytest.approx(0.1), 100, False)
    spent = in_c_mujoco(torque_budget=20.0)
    assert 20.0 <= spent.torque_cost < 22.0 and not spent.fell  # a step costs 0.3 to 2 N m s
    behind = in_c_mujoco(max_lag=0.1, min_speed=5.0)
    lag = 5.0 * behind.duration - behind.distance
    assert 0.1 < lag < 0.106 and not behind.fell  # 5 mm a step
    low = in_c_mujoco(min_hip_height=1.0)
    assert low.steps == 1 and low.fell


def test_a_lighter_body_is_noticed(planar: Agreement) -> None:
    walker = shorter("planar-lpd", max_time=1.5, torso_mass=35.0)
    experiment = walker.experiment
    key = jax.random.fold_in(jax.random.key(1), comparing.VERIFY)
    heights = np.asarray(experiment.sample_trials(key, 3))
    outcome = trials.run(experiment.env, experiment.controller, walker.genotype, heights)
    lighter = agreement.side("C MuJoCo", outcome, experiment.weight)
    told = {"walker": "a", "generation": 1, "seed": 1, "roughness_m": 0.0}
    assert not agreement.compare(planar.engine, lighter, **told).agrees


def test_a_run_that_diverges_ends_so() -> None:
    outcome = in_c_mujoco(integrator="explicit", contact=SoftContact(damping=1e6))
    assert outcome.diverged.all() and outcome.fell.all()
    assert np.isfinite(outcome.work).all()


@pytest.mark.parametrize("shape", [RandomWalk(), SerpentineWalk(length=8.0, width=2.0)])
def test_ground_is_as_high_as_the_walkers_is(shape: Any) -> None:
    heights = np.asarray(shape.sample(jax.random.key(0), 3))
    places = np.random.default_rng(0).uniform(-4.0, 9.0, (3, 40, 2))
    found = laws.height(shape, heights.astype(np.float64), places[..., 0], places[..., 1])
    tangents = 1 if isinstance(shape, RandomWalk) else 2
    for row in range(3):
        terrain: Any = Terrain(heights, np.int32(row))  # type: ignore[arg-type]
        expected = [shape.height(terrain, *jnp.float32(place[:tangents])) for place in places[row]]
        # float32 places on slopes of 0.2 at the most.
        np.testing.assert_allclose(found[row], expected, atol=2e-6)


def outcome(distance: list[float], fell: list[bool], work: float = 10.0) -> Outcome:
    one: Any = np.ones(len(distance))
    return Outcome(
        fitness=one,
        distance=np.array(distance),  # type: ignore[arg-type]
        duration=one,
        fell=np.array(fell),  # type: ignore[arg-type]
        diverged=one > 1,
        torque_cost=one,
        work=work * one,
        steps=one,
    )


def test_agreement_is_counted_by_hand() -> None:
    usual = agreement.side("lanes", outcome([4.0, 2.0], [False, True]), 2.0)
    other = agreement.side("C MuJoCo", outcome([4.0, 1.0], [False, False], work=8.0), 2.0)
    told = {"walker": "a", "generation": 1, "seed": 0, "roughness_m": 0.0}
    found = agreement.compare(usual, other, **told)
    assert usual.cost_of_transport == pytest.approx(20 / (2 * 6))
    assert found.distance_apart == pytest.approx(0.5 / 2.5)
    assert found.trial_apart == pytest.approx(0.5 / 2.5)
    assert found.cost_apart == pytest.approx(abs(20 / 12 - 16 / 10) / (16 / 10))
    assert (found.other_ends, found.agrees) == (1, False)
    assert agreement.compare(usual, usual, **told).agrees


def test_walkers_that_get_nowhere_have_no_cost() -> None:
    still = agreement.side("x", outcome([-1.0, 0.0], [True, True]), 2.0)
    found = agreement.compare(still, still, walker="a", generation=1, seed=0, roughness_m=0.0)
    assert found.cost_apart is None and found.agrees


def test_the_command_shows_and_writes_the_figures(
    planar: Agreement,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def verify(walker: Any, **asked: Any) -> Agreement:
        assert (asked["terrains"], asked["engine"]) == (3, "lanes")  # that it evolved with
        return planar

    monkeypatch.setattr(comparing, "verify", verify)
    out = tmp_path / "x.json"
    args = ["verify", "zoo:planar-lpd", "--terrains", "3", "--json", str(out)]
    assert cli.main(args) == 0
    shown = capsys.readouterr().out
    assert "agrees: distances" in shown and "0 of 3 trials end otherwise" in shown
    told = json.loads(out.read_text())
    assert told["engine"]["name"] == "lanes" and len(told["reference"]["distance_m"]) == 3
    planar = msgspec.structs.replace(planar, agrees=False)
    assert cli.main(args) == DISAGREES
    assert "does not agree" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("args", "complaint"),
    [
        ([], "RUN|zoo:NAME"),
        (["nowhere"], "nowhere does not exist"),
        (["zoo:nobody"], "there is no 'nobody' in the zoo"),
        (["zoo:planar-lpd", "--terrains", "0"], "--terrains must be at least 1, got 0"),
        (["zoo:planar-lpd", "--seed", "-1"], "--seed must be a whole number from 0 to 4294967295"),
        (["zoo:planar-lpd", "--roughness", "-1"], "--roughness must not be negative, got -1.0"),
        (["zoo:planar-lpd", "--json", "no/x.json"], "--json no/x.json is in no folder"),
        (["toy"], "toy has the body World; verify is set up for Planar7 and Flame"),
    ],
)
def test_wrong_input_is_one_sentence(
    args: list[str],
    complaint: str,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    if args == ["toy"]:
        toy.install(monkeypatch)
        assert cli.main(["evolve", "--generations", "2", "--out", "toy"]) == 0
        capfd.readouterr()
    assert cli.main(["verify", *args]) == 2
    error = capfd.readouterr().err
    assert complaint in error
    assert re.fullmatch(r"mjxwalk: [^\n]+\n", error)


def test_bodies_are_told_apart_by_their_exact_class() -> None:
    class Other(Planar7):
        """A body of somebody else's."""

    walker = shorter("planar-lpd")
    other = dataclasses.replace(walker.experiment, env=Other())
    with pytest.raises(ValueError, match="has the body Other"):
        comparing.verify(
            dataclasses.replace(walker, experiment=other),
            engine="mjx",
            terrains=1,
            seed=0,
            say=print,
        )


@pytest.mark.parametrize("name", ["planar-lpd", "flame-sil"])
def test_walkers_of_a_herd_have_the_jacobians_that_c_mujoco_gives_to_one(name: str) -> None:
    env = walkers.best(f"zoo:{name}").experiment.env
    rng = np.random.default_rng(6)
    coordinates = 9 if isinstance(env, Planar7) else 15
    qpos, qvel = rng.normal(size=(2, 3, coordinates))
    herd = bodies.Walkers(env, qpos, qvel, np.zeros((3, 2, 2)))
    mujoco.mj_forward(herd.data.model, herd.data)
    body = herd.body
    points = herd.data.site_xpos.reshape(3, -1, 3)[:, body.sites]
    found = herd.jacobian(points)
    for walker in range(3):
        one = mujoco.MjData(body.model)
        one.qpos[:], one.qvel[:] = herd.qpos[walker], herd.qvel[walker]
        mujoco.mj_forward(body.model, one)
        expected = np.zeros((3, body.model.nv))
        for place, site in enumerate(body.sites):
            mujoco.mj_jacSite(body.model, one, expected, None, site)
            np.testing.assert_allclose(found[walker, place], expected, atol=1e-12)
        bias = herd.data.qfrc_bias.reshape(3, -1)[walker]
        np.testing.assert_allclose(bias, one.qfrc_bias, atol=1e-9)
