"""Tests of senses: they are those of the environment, for every body."""

from typing import Any

import jax
import numpy as np
import pytest
from verify.stepped import BODIES, started

from mjxwalk.verify.senses import Senses


@pytest.mark.parametrize("name", BODIES)
def test_walkers_sense_what_their_environment_says(name: str) -> None:
    env = BODIES[name]
    _, states = started(env)
    random = np.random.default_rng(0)
    num = len(env.anatomy.coordinates)

    def shaken(state: Any) -> Any:
        qpos, qvel = random.normal(size=(2, num)).astype(np.float32)
        touching = random.random(len(env.anatomy.points)) > 0.7
        ankle_x = random.normal(size=2).astype(np.float32)
        return state._replace(qpos=qpos, qvel=qvel, touching=touching, ankle_x=ankle_x)

    states = [shaken(state) for state in states]
    seen = [env.observe(state) for state in states]
    qpos, qvel = (np.array([getattr(state, part) for state in states]) for part in ("qpos", "qvel"))
    counted = {part: np.array([getattr(each, part) for each in seen]) for part in COUNTED}
    found = Senses(env.anatomy, jax.eval_shape(env.observe, states[0])).of(qpos, qvel, counted)
    assert type(found) is type(seen[0])
    jax.tree.map(np.testing.assert_array_equal, found, jax.tree.map(lambda *r: np.stack(r), *seen))


COUNTED = ("time", "contact", "ankle_x")
