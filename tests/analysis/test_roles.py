"""Tests of angles by role of bodies of files, against where C MuJoCo has feet and toes."""

import functools
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import robots
from mjxwalk.analysis import roles
from mjxwalk.analysis.roles import Roles
from mjxwalk.envs import Flame, Planar7, Reil
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import reader
from mjxwalk.envs.mjcf_env import MjcfEnv

SMALL = 0.01  # rad


@functools.cache
def env_of(name: str) -> MjcfEnv:
    """Returns the environment of a body that ships."""
    return MjcfEnv.of(reader.read(robots.path(name)).text)


def roles_of(name: str) -> Roles:
    found = roles.roles_of(env_of(name))
    assert found is not None
    return found


def toe(env: MjcfEnv, qpos: Any, leg: int) -> Any:
    """Returns where the toe of a leg is, m."""
    data = mujoco.MjData(env.model.mujoco)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(env.model.mujoco, data)
    foot = data.body(env.anatomy.legs[leg].foot)
    _, end = env.anatomy.heel_and_toe(env.anatomy.legs[leg])
    return foot.xpos + foot.xmat.reshape(3, 3) @ end


def angles(env: MjcfEnv, found: Roles, qpos: Any, *, left_stance: bool) -> dict[str, float]:
    """Returns the angles by role in a pose, rad."""
    state = env.start(env.level_trials().given(0))
    seen = env.sense(state._replace(qpos=jnp.asarray(qpos, float)))
    return dict(
        zip(
            found.names,
            np.asarray(found.sense(seen, jnp.asarray(left_stance)).angle).tolist(),
            strict=True,
        )
    )


@pytest.mark.parametrize("name", ["walker2d", "h1"])
def test_bending_and_lifting_are_positive(name: str) -> None:
    env, found = env_of(name), roles_of(name)
    qpos = np.zeros(len(env.anatomy.coordinates))
    for leg, side in enumerate(env.anatomy.legs):
        for role, axis, way in (("hip", 0, 1.0), ("knee", 0, -1.0), ("ankle", 2, 1.0)):
            moved = qpos.copy()
            moved[getattr(side, role)] = SMALL
            shift = toe(env, moved, leg)[axis] - toe(env, qpos, leg)[axis]
            angle = angles(env, found, moved, left_stance=leg == 0)[f"stance {role}"]
            assert angle == pytest.approx(SMALL * np.sign(way * shift), abs=1e-6)
            swung = angles(env, found, moved, left_stance=leg == 1)
            assert swung[f"swing {role}"] == angle and swung[f"stance {role}"] == 0.0


@pytest.mark.parametrize("name", ["walker2d", "h1"])
def test_a_torso_that_leans_forward_is_positive(name: str) -> None:
    env, found = env_of(name), roles_of(name)
    qpos = np.zeros(len(env.anatomy.coordinates))
    qpos[env.anatomy.root.pitch] = 0.3
    assert angles(env, found, qpos, left_stance=True)["torso"] == pytest.approx(0.3, abs=1e-6)


def test_a_role_that_a_body_has_not_is_left_out() -> None:
    assert not any("ankle" in name for name in roles_of("humanoid").names)
    assert roles_of("walker2d").names[-1] == "swing ankle"


def test_bodies_of_the_paper_have_its_roles() -> None:
    assert roles.roles_of(Planar7()) is roles.PLANAR
    assert roles.roles_of(Flame()) is roles.SPATIAL
    assert roles.roles_of(Reil()) is None
    # The same body as a file walks by other senses.
    assert not roles_of("flame").is_paper
