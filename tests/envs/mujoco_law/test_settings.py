"""Tests of settings of MuJoCo's contacts, and of bodies that its law refuses."""

from typing import Any

import pytest
from mujoco_bodies import SMALL

from mjxwalk.envs import MjcfEnv
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mujoco_law import model as mujoco_model
from mjxwalk.envs.mujoco_law.settings import MujocoContact


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({"iterations": 0}, "iterations must be from 1 to 2,147,483,647, got 0"),
        ({"iterations": 1001}, "iterations must be at most 1000, got 1001"),
        ({"ls_iterations": 0.5}, "ls_iterations must be from 1 to 2,147,483,647, got 0.5"),
        ({"cone": "round"}, 'cone must be one of "pyramidal", "elliptic", got "round"'),
        (
            {"integrator": "implicit"},
            'integrator must be one of "euler", "implicitfast", "rk4", got "implicit"',
        ),
    ],
)
def test_wrong_settings_are_refused_in_a_sentence(settings: Any, complaint: str) -> None:
    law = MujocoContact()
    for name, value in settings.items():  # the tests' checker of types would refuse some first
        object.__setattr__(law, name, value)
    with pytest.raises(ValueError) as refused:
        law.__post_init__()
    assert str(refused.value) == complaint


def built(text: str, law: MujocoContact) -> Any:
    """Returns the `mujoco.MjModel` of a body under a law."""
    return mujoco_model.of_text(text, law, 0.003).mujoco


def test_what_is_not_set_is_the_files() -> None:
    text = SMALL.replace("<default>", '<option iterations="7" cone="elliptic"/><default>', 1)
    own = built(text, MujocoContact()).opt
    assert (own.iterations, own.cone) == (7, mujoco.mjtCone.mjCONE_ELLIPTIC)
    assert own.integrator == mujoco.mjtIntegrator.mjINT_EULER
    law = MujocoContact(iterations=3, ls_iterations=5, cone="pyramidal", integrator="rk4")
    asked = built(text, law).opt
    assert (asked.iterations, asked.ls_iterations) == (3, 5)
    assert asked.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
    assert asked.integrator == mujoco.mjtIntegrator.mjINT_RK4
    assert asked.timestep == 0.003


def test_parts_of_the_body_touch_each_other_only_if_they_may() -> None:
    text = SMALL.replace('\n          conaffinity="1"/>', ' contype="1" conaffinity="1"/>')
    for may, contacts in ((True, 1), (False, 0)):
        model = built(text, MujocoContact(self_collision=may))
        data = mujoco.MjData(model)
        data.qpos[1] = 9.0  # m; in the air
        model.geom_margin[:] = 1.0
        mujoco.mj_forward(model, data)
        touching = {tuple(sorted(map(int, each.geom))) for each in data.contact}
        feet = {pair for pair in touching if int(model.geom_bodyid[pair[0]]) > 0}
        assert len(feet) == contacts


LEFT = '<joint name="hip_left" '
REFUSED = {
    "no contacts": (
        "<default>",
        "<option><flag contact='disable'/></option><default>",
        "a <flag> disables contact, without which nothing stands; remove it",
    ),
    "no slip": (
        "<default>",
        "<option noslip_iterations='3'/><default>",
        "it has no noslip_iterations; remove them from the <option>",
    ),
    "cubic springs": (
        LEFT,
        LEFT + "stiffness='1 2 3' ",
        "joint hip_left has higher terms of spring or damper; keep the first number of each",
    ),
    "carried by motors": (
        LEFT,
        LEFT + "actuatorgravcomp='true' ",
        "motors do not carry gravity of joint hip_left; remove its actuatorgravcomp",
    ),
    "a root that is held": (
        'axis="1 0 0" damping="0"',
        'axis="1 0 0" damping="1"',
        "joint root_x moves the root, which nothing may hold; remove its damping, armature, "
        "frictionloss, stiffness and range",
    ),
    "a tendon's damper": (
        "<actuator>",
        "<tendon><fixed name='across' damping='1 2'><joint joint='hip_left' coef='1'/></fixed>"
        "</tendon><actuator>",
        "tendon across has higher terms of spring or damper; keep the first number of each",
    ),
}


@pytest.mark.parametrize(("old", "new", "complaint"), REFUSED.values(), ids=REFUSED)
def test_what_the_law_cannot_do_is_refused_by_name(old: str, new: str, complaint: str) -> None:
    assert old in SMALL
    with pytest.raises(ValueError) as refused:
        MjcfEnv.of(SMALL.replace(old, new, 1), contact_law="mujoco")
    assert str(refused.value) == f"contact law mujoco: {complaint}, or use contact law points"


def test_contacts_that_mjx_cannot_compute_are_refused_in_a_sentence() -> None:
    solid = "contype='2' conaffinity='2' mass='0.1'"
    leg, geoms = (
        'size="0.02" mass="0.7"/>',
        (
            f"<geom type='box' size='0.02 0.02 0.02' {solid}/>",
            f"<geom type='ellipsoid' size='0.02 0.02 0.01' {solid}/>",
        ),
    )
    text = SMALL
    first, middle, last = text.split(leg)
    text = first + leg + geoms[0] + middle + leg + geoms[1] + last
    with pytest.raises(ValueError, match="MJX cannot compute it .*; use contact law points, or"):
        MjcfEnv.of(text, contact_law="mujoco")
