"""An environment that keeps the protocol alone evolves; tools that need its body say so."""

import dataclasses
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import pytest

from mjxwalk import cli, experiments
from mjxwalk.controllers import LinearReactive
from mjxwalk.envs import Action, Planar7
from mjxwalk.experiments.experiment import Experiment, StrategyChoice

PLANAR = Planar7(max_time=0.5)


@dataclasses.dataclass(frozen=True)
class Bare:
    """The planar walker behind nothing but the protocol."""

    timestep: float = 0.001

    def sample_trials(self, key: Any, num: int, roughness: float | None = None) -> Any:
        return PLANAR.sample_trials(key, num, roughness)

    def reset(self, given: Any) -> Any:
        return PLANAR.reset(given)

    def observe(self, state: Any) -> Any:
        return PLANAR.observe(state)

    def step(self, state: Any, action: Any, given: Any) -> Any:
        return PLANAR.step(state, action, given)

    def fitness(self, state: Any) -> Any:
        return PLANAR.fitness(state)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Wide(LinearReactive):
    """Asks twice as many motors as there are."""

    def act(self, weights: Any, memory: Any, observation: Any) -> tuple[Any, Action]:
        memory, action = super().act(weights, memory, observation)
        return memory, Action(*(jnp.concatenate([part, part]) for part in action))


def experiment(name: str, env: Any, controller: Any) -> Experiment:
    return Experiment(
        name=name,
        env=env,
        controller=controller,
        strategy=StrategyChoice(name="snes", options={"sigma": 0.5}),
        population_size=8,
        generations=2,
        terrains_per_evaluation=1,
    )


def test_protocol_alone_evolves_and_tools_say_what_they_need(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    experiments.register(experiment("bare", Bare(), LinearReactive()))
    run = str(tmp_path / "run")
    assert cli.main(["evolve", "bare", "--out", run]) == 0
    for command in (
        ["watch", run],
        ["watch", run, "--video", str(tmp_path / "x.gif")],
        ["verify", run],
        ["export", run, "--to", "mjcf"],
        ["export", run, "--to", "onnx"],
        ["export", run, "--to", "sto"],
    ):
        capsys.readouterr()
        assert cli.main(command) == 2, command
        told = capsys.readouterr().err
        assert "Bare" in told and "LeggedEnv" in told and "Traceback" not in told


def test_action_of_another_width_is_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    experiments.register(experiment("wide", PLANAR, Wide()))
    assert cli.main(["evolve", "wide", "--out", str(tmp_path / "run")]) == 2
    told = capsys.readouterr().err
    assert "must have 6 numbers, for hip_left" in told and told.count("\n") == 1
