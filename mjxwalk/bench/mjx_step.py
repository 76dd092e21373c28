"""MJX itself: `mjx.step` of the model that C MuJoCo steps, contacts included."""

from typing import Any

import jax
from jaxtyping import Array

from mjxwalk.bench.contact_bodies import HELD, ContactBody
from mjxwalk.bench.workload import Workload
from mjxwalk.envs._mujoco import mjx
from mjxwalk.envs.mujoco_law.forward import MujocoState


def mjx_workload(body: ContactBody, size: int) -> Workload:
    """Returns walkers of a body that `mjx.step` moves; policy and starts are as elsewhere."""
    found = body.c_model()
    model, data = mjx.put_model(found), mjx.make_data(found)

    def advance(genotype: Any, given: Any, state: MujocoState) -> MujocoState:
        del given
        ctrl: Array = body.control(genotype, state.qpos, state.qvel)
        before = data.replace(
            qpos=state.qpos, qvel=state.qvel, qacc_warmstart=state.qacc_warmstart, ctrl=ctrl
        )
        after = jax.lax.fori_loop(0, HELD, lambda _, at: mjx.step(model, at), before)
        return MujocoState(after.qpos, after.qvel, after.qacc_warmstart)

    return body.workload(size)._replace(advance=advance)
