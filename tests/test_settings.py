"""Tests of settings as data and as paths."""

import dataclasses

import msgspec
import pytest
import toy

from mjxwalk.errors import RunError
from mjxwalk.experiments import get
from mjxwalk.experiments.ramp import RoughnessRamp
from mjxwalk.settings import from_data, override, to_data

TOY = toy.Toy()


@pytest.mark.parametrize("experiment", [TOY, get("planar-lpd")], ids=["toy", "planar-lpd"])
def test_settings_read_back_equal(experiment: object) -> None:
    changed = override(experiment, "population_size", "7")
    changed = override(changed, "strategy.sigma", "0.25")
    text = msgspec.json.encode(to_data(changed))
    assert from_data(experiment, msgspec.json.decode(text)) == changed
    assert changed != experiment


def test_nested_settings_keep_their_class() -> None:
    changed = override(TOY, "env.terrain.roughness", "0.5")
    assert changed == dataclasses.replace(
        TOY, env=dataclasses.replace(TOY.env, terrain=toy.Ground(roughness=0.5))
    )


def test_a_group_that_is_null_begins_with_its_usual_values() -> None:
    walk = get("walk")
    assert walk.ramp is None
    changed = override(override(walk, "ramp.start", "0.0005"), "ramp.distance", "3")
    assert changed.ramp == RoughnessRamp(start=0.0005, distance=3.0)
    assert from_data(walk, to_data(changed)) == changed
    with pytest.raises(RunError, match="unknown setting ramp.strat; did you mean start"):
        override(walk, "ramp.strat", "1")
    with pytest.raises(RunError, match="single setting and has no 'x' inside"):
        override(walk, "restart_after.x", "1")


@pytest.mark.parametrize(
    ("path", "text", "value"),
    [("friction", "1", 1.0), ("friction", "1e-3", 1e-3), ("friction", ".5", 0.5)],
)
def test_numbers_are_read_as_people_write_them(path: str, text: str, value: float) -> None:
    changed = override(TOY, f"env.{path}", text)
    assert changed.env.friction == value
    assert isinstance(changed.env.friction, float)


def test_a_name_of_digits_stays_a_text() -> None:
    assert override(TOY, "name", "123").name == "123"


@pytest.mark.parametrize(
    ("path", "text", "complaint"),
    [
        ("env.frction", "1", "unknown setting env.frction; did you mean friction?"),
        ("env.friction", "rough", "env.friction must be a number, got 'rough'"),
        ("env.terrain.shape", "hills", "must be one of flat, steps, got 'hills'"),
        ("env.terrain.roughness", "-1", "env.terrain: roughness must not be negative, got -1.0"),
        ("env.terrain", "1", "set one of env.terrain.roughness, env.terrain.shape"),
        ("env.friction.x", "1", "env.friction is a single setting and has no 'x' inside"),
        ("population_size", "2.5", "population_size must be a whole number"),
        ("population_size", "-3", "population_size must be positive, got -3"),
        ("strategy.sigma", "big", "strategy.sigma must be a number, got 'big'"),
    ],
)
def test_a_wrong_override_is_one_sentence(path: str, text: str, complaint: str) -> None:
    with pytest.raises(RunError) as caught:
        override(TOY, path, text)
    assert complaint in str(caught.value)


def test_unknown_missing_and_mistyped_settings_are_named() -> None:
    data = to_data(TOY)
    with pytest.raises(RunError, match="unknown setting env.gravity"):
        from_data(TOY, {**data, "env": {**data["env"], "gravity": 9.8}})
    with pytest.raises(RunError, match="setting generations is missing"):
        from_data(TOY, {k: v for k, v in data.items() if k != "generations"})
    with pytest.raises(RunError, match="generations must be a whole number, got 'six'"):
        from_data(TOY, {**data, "generations": "six"})
    with pytest.raises(RunError, match="env must be a table of settings, got 3"):
        from_data(TOY, {**data, "env": 3})
