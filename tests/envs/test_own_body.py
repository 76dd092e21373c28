"""Tests of bodies that users bring: against C MuJoCo, and what is refused."""

import dataclasses
import functools
import re
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import experiments
from mjxwalk.envs import Action, Flame, Planar7, RandomWalk, SerpentineWalk
from mjxwalk.envs.bodies import flame_body, planar7_body
from mjxwalk.experiments import own_body
from mjxwalk.verify.reference import Reference

CHILD = (Path(__file__).parents[2] / "docs/bodies/child.xml").read_text()
OURS = planar7_body.MODEL_PATH.read_text()
FLAME = flame_body.MODEL_PATH.read_text()


def changed(text: str, *changes: tuple[str, str]) -> str:
    """Returns the text with each pattern replaced wherever it is."""
    for old, new in changes:
        found, num = re.subn(old, new, text)
        assert num, old
        text = found
    return text


# Heavier shanks, a longer thigh, springs, weak motors, inertias that are not along the axes.
SPATIAL = changed(
    FLAME,
    (r'pos="0 (-?)0\.014 -0\.3155"', r'pos="0.01 \g<1>0.02 -0.36"'),
    (r'mass="0\.267"', 'mass="0.4"'),
    (r'(<joint name="knee_\w+")', r'\1 stiffness="3" springref="20" damping="0.3"'),
    (r'(<joint name="adduction_\w+")', r'\1 stiffness="5" damping="0.2" armature="0.01"'),
    (r'(<joint name="ankle_roll_\w+")', r'\1 stiffness="8" damping="0.15"'),
    (r'(<joint name="(?:ankle|hip)_(?:left|right)")', r'\1 actuatorfrcrange="-4 5"'),
    (
        r'<inertial pos="0\.0331 (.*?)" mass="0\.164" diaginertia="[^"]*"',
        r'<inertial pos="0.0331 \1" mass="0.164" '
        'fullinertia="0.0001 0.00048 0.00054 0 0.00003 0"',
    ),
)


def drive(num: int, time: float) -> Action:
    """Pushes joints back and forth, harder than weak motors can, with springs and dampers."""
    swing = np.sin(20.0 * time + np.arange(num))
    parts = 12.0 * swing, 0.3 * swing, np.full(num, 20.0), np.full(num, 0.5)
    return Action(*(jnp.asarray(part, jnp.float32) for part in parts))


@functools.cache
def stepper(env: Any) -> Any:
    trials = env.level_trials()
    trial = trials.given(jnp.zeros((), jnp.int32))
    step = jax.jit(lambda state, action: env.step(state, action, trial))
    return env.reset(trial), step, trials


PLANAR_ENV = own_body.with_body(
    dataclasses.replace(
        experiments.get("planar-lpd"),
        env=Planar7(terrain=RandomWalk(roughness=0.0), max_flight_time=9.0),
    ),
    changed(
        CHILD,
        (r'(<joint name="knee_\w+")', r'\1 stiffness="4" springref="15" armature="0.02"'),
        (r'gear="45"', 'gear="6"'),
    ),
).env
SPATIAL_ENV = own_body.with_body(
    dataclasses.replace(
        experiments.get("solomon-3d"),
        env=Flame(
            terrain=SerpentineWalk(roughness=0.0, length=10.0, width=2.0), max_flight_time=9.0
        ),
    ),
    SPATIAL,
).env


def lenient(env: Any) -> Any:
    more: Any = {"max_roll": 3.0, "max_yaw": 3.0} if isinstance(env, Flame) else {}
    return dataclasses.replace(env, min_hip_height=0.01, max_pitch=3.0, **more)


@pytest.mark.parametrize(
    ("env", "num"),
    [(PLANAR_ENV, 6), pytest.param(SPATIAL_ENV, 7, marks=pytest.mark.slow)],
    ids=["planar", "spatial"],
)
def test_another_body_moves_as_in_c_mujoco(env: Any, num: int) -> None:
    env = lenient(env)
    state, step, trials = stepper(env)
    oracle = Reference(env, [state.qpos], [state.qvel], trials)
    touched, limited = 0, 0
    for i in range(150):
        action = drive(num, i * env.timestep)
        given = oracle.step(jax.tree.map(lambda part: np.asarray(part)[None], action))
        state = step(state, action)
        touched += int(state.touching.any())
        limited += int((given.torque.T == oracle.limits).sum())
    assert touched > 50 and limited > 30 and not state.trial.done
    # float32 contact springs as in the tests of our own bodies.
    np.testing.assert_allclose(state.qpos, oracle.qpos[0], atol=2e-4)
    np.testing.assert_allclose(state.qvel, oracle.qvel[0], atol=2e-2)


REFUSED = {
    "<mujoco": (r"(?s)^.*$", "walker", "is no XML"),
    "element": (r"<worldbody>", "<worldbody><bdy/>", "a body may have no <bdy>"),
    "include": (
        r"<worldbody>",
        '<include file="x.xml"/><worldbody>',
        "a body may have no <include>",
    ),
    "mesh": (
        r"<worldbody>",
        '<asset><mesh file="a.stl"/></asset><worldbody>',
        "<mesh> may have no file",
    ),
    "massless": (r'mass="0\.98"', 'mass="0"', "MuJoCo cannot compile it"),
    "body": (r"foot_left", "foot_l", "has no body foot_left"),
    "joint": (r"knee_left", "kne_left", "must have the joints knee_left (hinge)"),
    "kind": (r'(name="knee_left")', r'\1 type="slide"', "has knee_left (slide)"),
    "free": (r'(?s)<joint name="root_x".*?(?=<inertial)', "<freejoint/>", "has no name (free"),
    "axis": (r'(name="hip_\w+") axis="0 -1 0"', r'\1 axis="0 1 0"', 'axis="0 -1 0"'),
    "anchor": (r'(name="knee_left")', r'\1 pos="0 0 0.1"', "must be at its body's origin"),
    "extra": (r'(<body name="head".*>)', r"\1<joint/>", "body head has a joint (without a name)"),
    "beside": (r"</worldbody>", '<body name="box"/></worldbody>', "body box lies beside torso"),
    "lifted": (r'name="torso"', 'name="torso" pos="0 0 1"', "must have pos 0 0 0"),
    "bent": (r'(name="shank_\w+") pos="0', r'\1 pos="0.1', "must lie straight below"),
    "turned": (r'name="head"', 'name="head" euler="0 9 0"', "body head is turned"),
    "gravcomp": (r'name="head"', 'name="head" gravcomp="1"', "body head has gravcomp"),
    "site": (r'<site name="heel_left".*', "", "has no site heel_left, where foot_left"),
    "sole": (r'(name="heel_\w+" pos="-0.047 0) -0.045', r"\1 -0.04", "must be at one height"),
    "gravity": (r"<option", '<option gravity="0 0 -1.6"', "has gravity 0 0 -1.6"),
    "integrator": (r'"Euler"', '"RK4"', "has the integrator RK4"),
    "no step": (r"<option", '<option timestep="1e-300"', "has timestep 1e-300 in <option>"),
    "backwards": (r"<option", '<option timestep="-0.001"', "has timestep -0.001 in <option>"),
    "still": (r"<option", '<option timestep="0"', "has timestep 0 in <option>"),
    "long step": (r"<option", '<option timestep="1e9"', "has timestep 1e+09 in <option>"),
    "nan": (r"<option", '<option timestep="nan"', "<option> has nan in timestep"),
    "air": (r"<option", '<option density="1.2"', "has air or water"),
    "collides": (r'contype="0"', 'contype="1"', "of body torso would collide"),
    "equality": (
        r"</mujoco>",
        '<equality><joint name="e" joint1="hip_left"/></equality></mujoco>',
        "has the equality constraint e",
    ),
    "tendon": (
        r"</mujoco>",
        '<tendon><fixed><joint joint="hip_left" coef="1"/></fixed></tendon></mujoco>',
        "has the tendon number 0, and the engines have none",
    ),
    "pair": (
        r"</mujoco>",
        '<contact><pair geom1="a" geom2="b"/></contact><worldbody><geom name="b" size="9 9 9" '
        'type="plane"/><body><geom name="a" size="1" type="sphere"/></body></worldbody></mujoco>',
        "has a <pair> by which the geoms b and a would collide",
    ),
    "key": (
        r"</mujoco>",
        '<keyframe><key name="home"/></keyframe></mujoco>',
        "has the keyframe home",
    ),
    "springs": (r"<option", '<option><flag spring="disable"/></option><option', "disables spring"),
    "override": (r"<option", '<option><flag override="enable"/></option><option', "enables over"),
    "friction": (r'(name="knee_left")', r'\1 frictionloss="1"', "joint knee_left has frictionloss"),
    "damped": (r'(name="root_x") class="root"', r"\1", "joint root_x has damping"),
    "endless": (r'range="0 130"', "", "joint knee_left has no range"),
    "range": (r'range="0 130"', 'range="9 130"', "which must hold 0"),
    "narrow": (r'range="-40 40"', 'range="-4 4"', "joint ankle_left has the range"),
    "servo": (r"<motor name=.knee_left.", '<position kp="9" name="knee_left"', "no plain motor"),
    "missing": (r".*<motor name=.knee_left.*", "", "has motors, but none for knee_left"),
    "twice": (r'joint="knee_left" gear', 'joint="hip_left" gear', "drives hip_left"),
    "lopsided": (r'name="thigh_left"', 'name="thigh_left" pos="0 0.1 0"', "does not mirror"),
    "limp": (r'(name="knee_left" .*gear)="45"', r'\1="20"', "its torque limits"),
    "heavy": (r'(?s)(shank_left.*?mass)="0.98"', r'\1="1.2"', "its mass would have to be 1.2"),
}
EVERYWHERE = ("axis", "bent", "joint", "narrow", "sole")  # of the other cases the first match


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_simulated_is_refused_with_what_to_do(case: str) -> None:
    old, new, complaint = REFUSED[case]
    text = re.sub(old, new, CHILD, count=0 if case in EVERYWHERE else 1)
    assert text != CHILD
    with pytest.raises(ValueError, match=re.escape(complaint)):
        Planar7(body=text)


def test_the_planar_and_the_spatial_body_are_told_apart() -> None:
    with pytest.raises(ValueError, match="body torso must have the joints root_x"):
        Planar7(body=FLAME)
    with pytest.raises(ValueError, match=r"root_y \(slide\), .* and has root_x \(slide\), root_z"):
        Flame(body=OURS)
