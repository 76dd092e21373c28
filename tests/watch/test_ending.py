"""Tests of the words on why a trial ended, by states made by hand."""

from typing import Any

import numpy as np
import pytest

from mjxwalk.envs import Flame, Planar7
from mjxwalk.envs.flame import State as FlameState
from mjxwalk.envs.planar7 import State as PlanarState
from mjxwalk.watch import ending


def state(kind: Any, size: int, height: float, **changes: Any) -> Any:
    """Returns a walker that stands; numpy."""
    usual: dict[str, Any] = dict.fromkeys(kind._fields, np.float32(0))
    usual |= {"num_steps": np.int32(5000), "done": np.bool_(True)}
    usual |= {name: np.bool_(False) for name in ("fell", "diverged")}
    usual["qpos"] = np.zeros(size, np.float32)
    usual["qpos"][1 if size == 9 else 2] = height
    usual["qpos"][0] = 5.0
    return kind(**(usual | changes))


def planar(pitch: float = 0.0, height: float = 0.9, **changes: Any) -> Any:
    made = state(PlanarState, 9, height, **changes)
    made.qpos[2] = pitch
    return made


def test_every_end_has_its_reason() -> None:
    env = Planar7()
    fell: dict[str, Any] = {"fell": np.bool_(True)}
    cases = {
        "open": planar(done=np.bool_(False)),
        "broken": planar(diverged=np.bool_(True), **fell),
        "budget": planar(torque_cost=np.float32(env.torque_budget + 1)),
        "time": planar(num_steps=np.int32(30_000)),
        "slow": planar(),
        "fall": planar(height=0.7, **fell),
    }
    assert {kind: ending.explain(env, each, 0.0).kind for kind, each in cases.items()} == {
        kind: kind for kind in cases
    }
    open_text = ending.explain(env, cases["open"], 0.0).text
    assert open_text == "still walking after 5.0 s, when the recording ends"


@pytest.mark.parametrize(
    ("changes", "ground", "words"),
    [
        ({"height": 0.75}, 0.0, "fell: hips lower than 0.78 m"),
        ({"height": 0.90}, 0.15, "fell: hips lower than 0.78 m"),
        ({"pitch": 1.1}, 0.0, "fell: leaned forwards by more than 57°"),
        ({"pitch": -1.1}, 0.0, "fell: leaned backwards by more than 57°"),
        ({"flight_time": np.float32(0.003)}, 0.0, "fell: both feet in the air for over 2 ms"),
    ],
)
def test_a_fall_in_the_plane_names_the_rule(changes: Any, ground: float, words: str) -> None:
    fallen = planar(fell=np.bool_(True), **changes)
    assert ending.explain(Planar7(), fallen, ground).text == words


@pytest.mark.parametrize(
    ("coordinate", "value", "words"),
    [
        (3, 1.3, "fell: turned off its course by more than 69°"),
        (4, 0.6, "fell: leaned forwards by more than 29°"),
        (5, -0.8, "fell: leaned sideways by more than 40°"),
        (2, 0.5, "fell: hips lower than 0.555 m"),
    ],
)
def test_a_fall_in_space_names_the_rule(coordinate: int, value: float, words: str) -> None:
    fallen = state(FlameState, 15, 0.64, fell=np.bool_(True))
    fallen.qpos[coordinate] = value
    assert ending.explain(Flame(), fallen, 0.0).text == words
