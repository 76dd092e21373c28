"""Tests of the solver of constraints, given C MuJoCo's own rows, against its forces."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from c_contacts import CONVERGED, model_of, reference, text_of

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mujoco_law import solver
from mjxwalk.envs.mujoco_law.constraints import Cones, Part, Rows
from mjxwalk.envs.mujoco_law.settings import MujocoContact

ELLIPTIC = MujocoContact(iterations=100, ls_iterations=20, cone="elliptic")
OTHERS, PYRAMIDS = 24, 100  # most rows of a state
SLOTS = {3: 12, 4: 6, 6: 6}  # most contacts of each dimension
EQUAL, RUBS = int(mujoco.mjtConstraint.mjCNSTR_EQUALITY), range(1, 3)
LIMITS, CONTACTS = range(3, 5), range(5, 8)


class Problem(NamedTuple):
    """What the solver is given in one state, and what C MuJoCo makes of it."""

    mass: Any
    force: Any
    rows: Any
    friction: Any
    qacc: Any
    efc_force: Any


def problem(model: Any, data: Any, slots: dict[int, int]) -> Problem:
    """Returns that of a state in which C MuJoCo has solved; rows that are not there are zeros."""
    elliptic = int(model.opt.cone) == int(mujoco.mjtCone.mjCONE_ELLIPTIC)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    kinds = np.array(data.efc_type)
    found = data.efc_J.reshape(data.nefc, model.nv)
    rubs = np.isin(kinds, RUBS)
    lowest = np.where(kinds == EQUAL, -np.inf, np.where(rubs, -data.efc_frictionloss, 0.0))
    highest = np.where(rubs, data.efc_frictionloss, np.inf)
    values = np.stack([data.efc_D, data.efc_aref, lowest, highest, data.efc_force], axis=1)
    size = OTHERS + (sum(dim * num for dim, num in slots.items()) if elliptic else PYRAMIDS)
    jacobian, numbers = np.zeros((size, model.nv)), np.zeros((size, 5))
    places = np.flatnonzero(kinds < CONTACTS[0]) if elliptic else np.arange(data.nefc)
    jacobian[: len(places)], numbers[: len(places)] = found[places], values[places]
    friction, start = [], OTHERS
    for dim, num in slots.items() if elliptic else ():
        own = [each for each in data.contact if each.dim == dim and each.efc_address >= 0]
        ratios = np.ones((num, dim))
        for slot, contact in enumerate(own):
            place = start + slot * dim + np.arange(dim)
            source = contact.efc_address + np.arange(dim)
            jacobian[place], numbers[place] = found[source], values[source]
            ratios[slot] = [contact.mu, *contact.friction[: dim - 1]]
        friction.append(ratios)
        start += num * dim
    rows = jacobian, *numbers[:, :4].T
    return Problem(mass, data.qfrc_smooth.copy(), rows, friction, data.qacc.copy(), numbers[:, 4])


def problems(
    name: str, law: MujocoContact, slots: dict[int, int], num: int = 40
) -> tuple[Problem, set[int]]:
    """Returns those of a body that is thrown on the floor, and the kinds of rows in them."""
    model = reference(model_of(text_of(name), law))
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    found: list[Problem] = []
    kinds: set[int] = set()
    while len(found) < num:
        mujoco.mj_resetData(model, data)
        data.qpos[model.jnt_qposadr[1] if model.nq == model.nv else 2] = 0.4
        data.qvel[:] = 0.5 * rng.normal(size=model.nv)
        for step in range(400):
            if step % 20 == 0:
                data.qfrc_applied[-model.nu :] = 20.0 * rng.normal(size=model.nu)
            mujoco.mj_step(model, data)
            if step > 50 and step % 35 == 0 and data.ncon:
                mujoco.mj_forward(model, data)
                found.append(problem(model, data, slots))
                kinds |= set(data.efc_type.tolist())
    return jax.tree.map(lambda *leaves: np.stack(leaves), *found[:num]), kinds


def solved(given: Problem) -> solver.Solution:
    """Returns accelerations and forces in float32."""
    places: list[Any] = []
    start = 0
    for ratios in given.friction:
        num, dim = ratios.shape[1:]
        places.append(start + np.arange(num * dim).reshape(num, dim))
        start += num * dim

    def solve(mass: Any, force: Any, rows: Any, friction: Any) -> solver.Solution:
        cones = tuple(Cones(*each) for each in zip(places, friction, strict=True))
        others = Rows(*(each[:OTHERS] for each in rows))
        contacts = Rows(*(each[OTHERS:] for each in rows), cones=cones)
        parts = [
            Part(lambda: others),
            # Contacts are there in all states, and once more nowhere.
            Part(lambda: contacts, jnp.any(contacts.weight > 0.0)),
            Part(lambda: contacts, jnp.zeros((), bool)),
        ]
        return solver.solve(
            mass,
            force,
            parts,
            jnp.zeros_like(force),
            iterations=100,
            ls_iterations=20,
        )

    f32 = jax.tree.map(lambda leaf: np.asarray(leaf, np.float32), given[:4])
    return jax.jit(jax.vmap(solve))(*f32)


def check(name: str, law: MujocoContact, slots: dict[int, int], limits: set[int]) -> None:
    given, kinds = problems(name, law, slots)
    assert kinds >= {0, 1, 2, *limits}, "equality, friction of joints and tendons, limits"
    assert kinds & set(CONTACTS)
    ours = solved(given)
    # float32 has seven digits of the largest; 20 more digits' worth for sums and a solver's end.
    force, absent = np.split(ours.force, [given.efc_force.shape[1]], axis=1)
    assert not absent.any()
    for found, expected in ((ours.qacc, given.qacc), (force, given.efc_force)):
        off = np.abs(np.asarray(found) - expected).max(1)
        assert (off / np.abs(expected).max(1)).max() < 5e-6


@pytest.mark.parametrize("law", [CONVERGED, ELLIPTIC], ids=["pyramids", "cones"])
def test_forces_and_accelerations_are_c_mujocos(law: MujocoContact) -> None:
    check("small, tied", law, {3: 8}, {3, 4})


@pytest.mark.slow
@pytest.mark.parametrize("law", [CONVERGED, ELLIPTIC], ids=["pyramids", "cones"])
def test_contacts_that_turn_and_roll_have_c_mujocos_forces(law: MujocoContact) -> None:
    check("tied", law, SLOTS, {3})
