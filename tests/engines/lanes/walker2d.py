"""A planar walker with capsule feet after Gymnasium's Walker2d, for MuJoCo's own contacts."""

from typing import Any

from mjxwalk.envs._mujoco import mujoco

LEG = """
  <body name="thigh{s}" pos="0 0 -0.2">
    <joint name="hip{s}" pos="0 0 0" range="-150 0"/>
    <geom fromto="0 0 0 0 0 -0.45" size="0.05"/>
    <body name="leg{s}" pos="0 0 -0.7">
      <joint name="knee{s}" pos="0 0 0.25" range="-150 0"/>
      <geom fromto="0 0 0.25 0 0 -0.25" size="0.04"/>
      <body name="foot{s}" pos="0.1 0 -0.25">
        <joint name="ankle{s}" pos="-0.1 0 0" range="-45 45"/>
        <geom name="foot{s}" fromto="-0.1 0 0 0.1 0 0" size="0.06" contype="1" friction="{f}"/>
      </body>
    </body>
  </body>
"""

XML = """
<mujoco>
  <compiler angle="degree"/>
  <option timestep="0.002" integrator="Euler"/>
  <default>
    <joint type="hinge" axis="0 -1 0" armature="0.01" damping="0.1" limited="true"/>
    <geom type="capsule" contype="0" conaffinity="0" density="1000" friction="0.7"/>
    <motor gear="100" ctrlrange="-1 1" ctrllimited="true"/>
  </default>
  <worldbody>
    <geom name="floor" type="plane" size="40 40 1" conaffinity="1"/>
    <body name="torso" pos="0 0 1.25">
      <joint name="x" type="slide" axis="1 0 0" armature="0" damping="0" limited="false"/>
      <joint name="z" type="slide" axis="0 0 1" armature="0" damping="0" limited="false"/>
      <joint name="pitch" axis="0 1 0" armature="0" damping="0" limited="false"/>
      <geom fromto="0 0 0.2 0 0 -0.2" size="0.05"/>
      {left}
      {right}
    </body>
  </worldbody>
  <actuator>
    <motor joint="hip_left"/><motor joint="knee_left"/><motor joint="ankle_left"/>
    <motor joint="hip_right"/><motor joint="knee_right"/><motor joint="ankle_right"/>
  </actuator>
</mujoco>
"""


def model(*, iterations: int, ls_iterations: int) -> Any:
    """Returns the model; only its feet touch the floor.

    Args:
      iterations: of the constraint solver.
      ls_iterations: of its line search.
    """
    legs = {side: LEG.format(s=f"_{side}", f=f) for side, f in (("left", 1.9), ("right", 0.9))}
    built: Any = mujoco.MjModel.from_xml_string(XML.format(**legs))
    built.opt.iterations, built.opt.ls_iterations = iterations, ls_iterations
    return built
