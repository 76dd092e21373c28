"""Tests of senses: they are those of the environment, for every body."""

from typing import Any

import jax
import numpy as np
import pytest
from verify.stepped import BODIES, started

from mjxwalk.verify.senses import OF_TORSO, Senses


@pytest.mark.parametrize("name", BODIES)
def test_walkers_sense_what_their_environment_says(name: str) -> None:
    env = BODIES[name]
    _, states = started(env)
    random = np.random.default_rng(0)
    num = len(env.anatomy.coordinates)

    def shaken(state: Any) -> Any:
        qpos, qvel = random.normal(size=(2, num)).astype(np.float32)
        touching = random.random(len(env.anatomy.points)) > 0.7
        ankle_x = random.normal(size=len(env.anatomy.legs)).astype(np.float32)
        return state._replace(qpos=qpos, qvel=qvel, touching=touching, ankle_x=ankle_x)

    states = [shaken(state) for state in states]
    seen = [env.observe(state) for state in states]
    qpos, qvel = (np.array([getattr(state, part) for state in states]) for part in ("qpos", "qvel"))
    counted = {part: np.array([getattr(each, part) for each in seen]) for part in COUNTED}
    found = Senses(env.anatomy, jax.eval_shape(env.observe, states[0])).of(qpos, qvel, counted)
    assert type(found) is type(seen[0])
    for name, expected in jax.tree.map(lambda *rows: np.stack(rows), *seen)._asdict().items():
        if expected is None:
            continue
        # What is turned into the torso's axes is of some rad/s, in float32 there.
        close = 2e-6 if name in OF_TORSO else 0.0
        np.testing.assert_allclose(getattr(found, name), expected, rtol=close, atol=close)


COUNTED = ("time", "contact", "ankle_x")
