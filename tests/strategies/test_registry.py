"""Tests for strategies by name, and for what importing them loads."""

import subprocess
import sys
from typing import Any

import pytest

from mjxwalk import strategies


def test_a_name_makes_its_strategy():
    strategy = strategies.make("self-adaptive-ga", population_size=6, sigma=0.1, initial_sigma=0.1)
    assert strategy.population_size == 6


@pytest.mark.parametrize(
    ("name", "options", "sentence"),
    [
        (
            "self-adaptve-ga",
            {},
            "unknown strategy 'self-adaptve-ga'; did you mean self-adaptive-ga",
        ),
        ("zzz", {}, "unknown strategy 'zzz'; known are .*self-adaptive-ga"),
        ("self-adaptive-ga", {"sigm": 1.0}, "unknown option 'sigm' .*did you mean sigma"),
        ("self-adaptive-ga", {"sigma": 1.0}, "needs a value for initial_sigma"),
        ("self-adaptive-ga", {"sigma": -1.0, "initial_sigma": 1.0}, "sigma must be .*got -1"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(name: str, options: dict[str, Any], sentence: str):
    with pytest.raises(ValueError, match=sentence):
        strategies.make(name, population_size=6, **options)


def test_hyper_parameters_that_both_take_carry_over():
    given = {"sigma": 0.05, "initial_sigma": 0.3, "num_elites": 2}
    assert strategies.carry_over("sep-cma-es", given) == {"sigma": 0.3}
    assert strategies.carry_over("deep-ga", given) == given
    with pytest.raises(ValueError, match="did you mean snes"):
        strategies.carry_over("snse", given)


def test_importing_strategies_loads_no_physics():
    loaded = "import sys, mjxwalk.strategies; print('mujoco' in sys.modules)"
    result = subprocess.run([sys.executable, "-c", loaded], capture_output=True, check=True)
    assert result.stdout.strip() == b"False"
