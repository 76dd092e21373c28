"""Tests of the words on why a trial ended, by states made by hand."""

from typing import Any

import jax
import numpy as np
import pytest
from trial_states import counted

from mjxwalk.envs import Flame, LeggedEnv, Planar7, Reil, State


def state(env: LeggedEnv, height: float, **counts: Any) -> State:
    """Returns a walker that stands, 5 m from its start and after 5,000 steps; numpy."""
    start = env.reset(env.level_trials().given(0))
    zeros: Any = jax.tree.map(lambda leaf: np.zeros(leaf.shape, leaf.dtype), start)
    zeros.qpos[env.anatomy.root.forward], zeros.qpos[env.anatomy.root.height] = 5.0, height
    return counted(zeros, **{"num_steps": np.int32(5000), "done": np.bool_(True)} | counts)


def planar(pitch: float = 0.0, height: float = 0.9, **counts: Any) -> State:
    made = state(Planar7(), height, **counts)
    made.qpos[2] = pitch  # type: ignore[index]
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
    assert {kind: env.why_ended(each, 0.0).kind for kind, each in cases.items()} == {
        kind: kind for kind in cases
    }
    open_text = env.why_ended(cases["open"], 0.0).text
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
    assert Planar7().why_ended(fallen, ground).text == words


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
    fallen = state(Flame(), 0.64, fell=np.bool_(True))
    fallen.qpos[coordinate] = value  # type: ignore[index]
    assert Flame().why_ended(fallen, 0.0).text == words


def test_a_body_of_rules_of_its_own_tells_them() -> None:
    env = Reil()
    done = counted(env.reset(env.level_trials().given(0)), done=np.bool_(True))
    there = done._replace(qpos=done.qpos.at[0].set(20.5))
    assert env.why_ended(there, 0.0).text == "came to 20 m, where trials end"
    still = done._replace(own=done.own._replace(still_time=np.float32(1.6)))
    assert env.why_ended(still, 0.0).text == "its hips were asked to stand still"
    low = counted(done, fell=np.bool_(True))
    low = low._replace(own=done.own._replace(height=np.float32(0.5)))
    assert env.why_ended(low, 0.0).text.startswith("fell: centre of mass lower than 80%")
    turned = counted(done, fell=np.bool_(True))
    turned = turned._replace(qpos=done.qpos.at[3].set(1.2))
    assert env.why_ended(turned, 0.0).text == "fell: turned off its course by more than 57°"
