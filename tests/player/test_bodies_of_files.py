"""Tests of what the page is told about bodies of files, against the compiled model."""

import functools

import numpy as np
import pytest
from player.test_bodies import place

from mjxwalk import robots
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import reader
from mjxwalk.envs.mjcf_env import MjcfEnv
from mjxwalk.player import bodies

# Only one leg says its side; geoms are of every shape and in groups that viewers hide.
LEG = """<body name="{side}thigh" pos="0 {y} 0">
  <joint name="{side}hip" axis="0 1 0" range="-60 60"/>
  <geom type="capsule" size="0.05" fromto="0 0 0 0 0 -0.4" group="3"/>
  <body name="{side}shank" pos="0 0 -0.4"><joint name="{side}knee" axis="0 1 0" range="0 90"/>
    <geom type="ellipsoid" size="0.03 0.04 0.2" pos="0 0 -0.2" group="1"/>
    <geom type="sphere" size="0.02" group="4" pos="0 0 -0.2"/>
    <body name="{side}foot" pos="0 0 -0.4"><joint name="{side}ankle" axis="0 1 0" range="-40 40"/>
      <geom type="box" size="0.1 0.05 0.02" pos="0.05 0 -0.02"/></body></body></body>"""
MOTORS = "".join(
    f'<motor joint="{side}{joint}" gear="50" ctrlrange="-1 1"/>'
    for side in ("left_", "")
    for joint in ("hip", "knee", "ankle")
)
BIPED = f"""<mujoco model="drawn"><worldbody><body name="torso" pos="0 0 0.9"><freejoint/>
  <geom type="cylinder" size="0.1 0.2" pos="0 0 0.2"/>
  {LEG.format(side="left_", y=0.1)}{LEG.format(side="", y=-0.1)}
  </body></worldbody><actuator>{MOTORS}</actuator></mujoco>"""


@functools.cache
def env_of(text: str) -> MjcfEnv:
    return MjcfEnv.of(text)


def shipped(name: str) -> MjcfEnv:
    return env_of(reader.read(robots.path(name)).text)


@pytest.mark.parametrize("name", ["h1", "walker2d"])
def test_what_is_seen_of_a_shipped_body_is_where_mujoco_has_it(name: str) -> None:
    env = shipped(name)
    body, model, anatomy = bodies.describe(env), env.model.mujoco, env.anatomy
    coordinates = np.random.default_rng(0).uniform(-0.7, 0.7, len(anatomy.coordinates))
    data = mujoco.MjData(model)
    data.qpos[:] = coordinates[list(anatomy.joint_coordinate)]
    mujoco.mj_kinematics(model, data)
    geoms = [geom for geom in range(model.ngeom) if model.geom_group[geom] == 2]
    assert len(geoms) == len(body.parts)
    links = place(body, coordinates)
    for geom, part in zip(geoms, body.parts, strict=True):
        origin, axes = links[part.body]
        centre = origin + axes @ np.array(part.pos)
        assert centre == pytest.approx(data.geom_xpos[geom], abs=1e-5)
    for known, point in zip(anatomy.points, body.points, strict=True):
        origin, axes = links[point.body]
        foot = data.body(known.body)
        truth = foot.xpos + foot.xmat.reshape(3, 3) @ known.offset
        found = origin + axes @ np.array(point.pos)
        # Feet of a body in the plane are drawn apart, across it.
        seen = [0, 2] if anatomy.root.is_planar else [0, 1, 2]
        assert found[seen] == pytest.approx(truth[seen], abs=1e-5)


def test_parts_have_the_shape_that_the_file_says() -> None:
    body = bodies.describe(env_of(BIPED))
    names = [body.links[part.body].name for part in body.parts]
    shapes = dict(zip(names, (part.shape for part in body.parts), strict=True))
    # A hidden geom stands in where a body has no other.
    leg = (("thigh", "capsule"), ("shank", "ellipsoid"), ("foot", "box"))
    assert shapes == {
        "torso": "cylinder",
        **{f"left_{name}": shape for name, shape in leg},
        **{f"{name}_right": shape for name, shape in leg},
    }
    (shank,) = [part for part, name in zip(body.parts, names, strict=True) if name == "left_shank"]
    assert shank.size == (0.03, 0.04, 0.2)


def test_a_leg_has_one_side_whatever_its_bodies_are_called() -> None:
    env = env_of(BIPED.replace('body name="thigh"', 'body name="left_of_front_right"'))
    body = bodies.describe(env)
    sides = {body.links[part.body].name: part.side for part in body.parts}
    assert list(sides.values()).count("left") == list(sides.values()).count("right") == 3
    assert sides["torso"] == "middle"
    assert {(point.leg, point.side) for point in body.points} == {(0, "left"), (1, "right")}
