"""States of bodies under C MuJoCo's own contacts, and what a step makes of them, to compare with.

    JAX_ENABLE_X64=1 python c_contacts.py h1

prints the largest difference of a velocity between our step and C MuJoCo's, both in float64.
"""

import copy
import os
import sys
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from mujoco_bodies import TEXTS

from mjxwalk import robots
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.derived import anatomy
from mjxwalk.envs.mjcf import reader
from mjxwalk.envs.motor import Action
from mjxwalk.envs.mujoco_law import model as mujoco_model
from mjxwalk.envs.mujoco_law import step as mujoco_step
from mjxwalk.envs.mujoco_law.coordinates import Coordinates
from mjxwalk.envs.mujoco_law.forward import MujocoState
from mjxwalk.envs.mujoco_law.model import MujocoModel
from mjxwalk.envs.mujoco_law.settings import MujocoContact

CONVERGED = MujocoContact(iterations=100, ls_iterations=20)
FASTEST = 40.0  # rad/s; of states to compare


class Steps(NamedTuple):
    """States before a step, what motors are asked for, and C MuJoCo's states after it."""

    before: MujocoState
    action: Action
    qpos: Any
    qvel: Any
    contacts: Any


def text_of(name: str) -> str:
    """Returns the MJCF of a body that ships, of a file, or of one of `mujoco_bodies`."""
    if name in TEXTS:
        return TEXTS[name]
    path = robots.FOLDER / f"{name}.xml"
    return reader.read(path if path.exists() else Path(name)).text


def model_of(text: str, law: MujocoContact = CONVERGED) -> MujocoModel:
    """Returns the model of a body with its file's time step."""
    timestep = float(mujoco.MjSpec.from_string(text).option.timestep)
    return mujoco_model.of_text(text, law, timestep)


def reference(model: MujocoModel) -> Any:
    """Returns the `mujoco.MjModel` whose solver converges."""
    found = copy.deepcopy(model.mujoco)
    found.opt.iterations, found.opt.ls_iterations, found.opt.tolerance = 200, 50, 1e-15
    return found


def set_motors(found: Any, action: Any) -> None:
    """Lets a model's motors give what an action asks for."""
    torque, target, stiffness, damping = map(np.asarray, action)
    found.actuator_gainprm[:] = 0.0
    found.actuator_biasprm[:, :3] = np.stack(
        [torque + stiffness * target, -stiffness, -damping], axis=1
    )


def steps(text: str, model: MujocoModel, *, trials: int = 8, length: int = 400) -> Steps:
    """Returns every eighth state of bodies that fall, and lie, as their motors jerk."""
    found, rng = reference(model), np.random.default_rng(0)
    data = mujoco.MjData(found)
    start, motors = anatomy.stance(text), anatomy.anatomy(text).motors
    stiffness, damping = (
        np.array([getattr(each, name) for each in motors]) for name in ("stiffness", "damping")
    )
    places = np.array([each.coordinate for each in motors])
    rows: list[Any] = []
    for _ in range(trials):
        rates = 0.3 * rng.normal(size=found.nv)
        state = mujoco_step.begin(model, Coordinates(jnp.asarray(start.qpos), jnp.asarray(rates)))
        mujoco.mj_resetData(found, data)
        data.qpos[:], data.qvel[:] = np.asarray(state.qpos), np.asarray(state.qvel)
        action: Any = None  # of the first step
        for step in range(length):
            if step % 20 == 0:
                target = start.qpos[places] + 0.3 * rng.normal(size=found.nu)
                torque = 5.0 * rng.normal(size=found.nu)
                action = Action(torque, target, jnp.asarray(stiffness), jnp.asarray(damping))
                set_motors(found, action)
            before = MujocoState(data.qpos.copy(), data.qvel.copy(), data.qacc_warmstart.copy())
            mujoco.mj_step(found, data)
            if np.abs(data.qvel).max() > FASTEST:
                break
            if step > 20 and step % 8 == 0:
                after = data.qpos.copy(), data.qvel.copy(), data.ncon
                rows.append((before, action, *after))
    return Steps(*jax.tree.map(lambda *leaves: np.stack(leaves), *rows))


def stepping(model: MujocoModel) -> Any:
    """Returns our step as a function of a state and an action."""
    return lambda state, action: mujoco_step.step(model, state, action)[0]


def differences(name: str, law: MujocoContact = CONVERGED) -> Any:
    """Returns the largest difference of a velocity in each state."""
    text = text_of(name)
    model = model_of(text, law)
    given = steps(text, model)
    model = model._replace(mujoco=reference(model))
    after = jax.jit(jax.vmap(stepping(model)))(given.before, given.action)
    return np.abs(np.asarray(after.qvel) - given.qvel).max(1)


if __name__ == "__main__":
    assert os.environ.get("JAX_ENABLE_X64")
    print(differences(sys.argv[1]).max())
