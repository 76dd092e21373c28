"""Bodies with all that MuJoCo's constraints are for, in few joints."""

# 5 kg in the plane on two straight legs with feet like skates: few joints, and so soon compiled.
SMALL = """
<mujoco model="small">
  <option timestep="0.004"/>
  <default>
    <joint damping="0.2" armature="0.01"/><geom contype="0" conaffinity="0" friction="0.8"/>
    <motor ctrlrange="-20 20"/>
  </default>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1" contype="1"/>
    <body name="trunk" pos="0 0 0.4">
      <joint name="root_x" type="slide" axis="1 0 0" damping="0" armature="0"/>
      <joint name="root_z" type="slide" axis="0 0 1" damping="0" armature="0"/>
      <joint name="root_pitch" axis="0 1 0" damping="0" armature="0"/>
      <geom type="box" pos="0.01 0 0.1" size="0.06 0.08 0.1" mass="3"/>
      <body name="leg_left" pos="0 0.1 0">
        <joint name="hip_left" axis="0 -1 0" range="-40 40"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.36" size="0.02" mass="0.7"/>
        <geom type="capsule" fromto="-0.08 0 -0.37 0.12 0 -0.37" size="0.03" mass="0.3"
          conaffinity="1"/>
      </body>
      <body name="leg_right" pos="0 -0.1 0">
        <joint name="hip_right" axis="0 -1 0" range="-40 40"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.36" size="0.02" mass="0.7"/>
        <geom type="capsule" fromto="-0.08 0 -0.37 0.12 0 -0.37" size="0.03" mass="0.3"
          conaffinity="1"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="hip_left"/><motor joint="hip_right"/></actuator>
</mujoco>
"""
# A hopper on a leg that two joints tie to a second one, with a tendon, friction in a joint, and
# geoms of every shape that may touch the floor.
_TIED = """
<mujoco>
  <option timestep="0.003"/>
  <default>
    <joint damping="0.5" armature="0.02"/><geom density="500" contype="0" conaffinity="2"/>
  </default>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1" contype="2" conaffinity="0"/>
    <body name="trunk" pos="0 0 0.9">
      <freejoint/>
      <geom type="box" size="0.1 0.15 0.1"/>
      {legs}
    </body>
  </worldbody>
  <tendon>
    <fixed name="across" range="-0.2 0.3" damping="1" stiffness="20" frictionloss="0.5">
      <joint joint="hip_left" coef="1"/><joint joint="hip_right" coef="-1"/>
    </fixed>
  </tendon>
  <equality>
    <joint joint1="ankle_left" joint2="knee_left" polycoef="0 -0.5 0.1 0 0"/>
    <connect body1="heel_right" body2="foot_right" anchor="0 0 0"/>
  </equality>
  <actuator>
    <motor joint="hip_left" ctrlrange="-50 50"/><motor joint="knee_left" ctrlrange="-50 50"/>
    <motor joint="hip_right" ctrlrange="-50 50"/><motor joint="knee_right" ctrlrange="-50 50"/>
  </actuator>
</mujoco>
"""
_LEG = """
      <body name="thigh_{s}" pos="0 {y} -0.1">
        <joint name="hip_{s}" axis="0 1 0" range="-60 60"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.35" size="0.04" {solid}/>
        <body name="shin_{s}" pos="0 0 -0.35">
          <joint name="knee_{s}" axis="0 1 0" range="-10 120" frictionloss="1"/>
          <geom type="cylinder" fromto="0 0 0 0 0 -0.3" size="0.03"/>
          <body name="foot_{s}" pos="0 0 -0.35">
            <joint name="ankle_{s}" axis="0 1 0" range="-40 40"/>
            <geom type="{shape}" size="0.12 0.05 0.03" condim="{dim}"/>
            <body name="heel_{s}" pos="-0.1 0 0">
              <joint name="pad_{s}" type="slide" axis="0 0 1" range="-0.02 0.02"/>
              <geom type="sphere" size="0.04" condim="6" mass="0.2" {solid}/>
            </body>
          </body>
        </body>
      </body>
"""
_SOLID = 'contype="1" conaffinity="3"'
TIED = _TIED.format(
    legs=_LEG.format(s="left", y=0.1, shape="box", dim=4, solid=_SOLID)
    + _LEG.format(s="right", y=-0.1, shape="ellipsoid", dim=3, solid=_SOLID)
)
# The small body with its hips tied, in the way of each other's toes, and stopped early.
_TOE = (
    '<geom type="sphere" pos="{x} {y} -0.33" size="0.05" mass="0.1" contype="2" conaffinity="2"/>'
)
_LAWS = """
  <tendon>
    <fixed name="apart" range="-0.05 0.05" stiffness="5" damping="0.1" frictionloss="0.05">
      <joint joint="hip_left" coef="1"/><joint joint="hip_right" coef="-1"/>
    </fixed>
  </tendon>
  <equality>
    <joint joint1="hip_left" joint2="hip_right" polycoef="0 -0.5 0.2 0 0" solref="0.05 1"/>
  </equality>
  <actuator>"""
_LEFT, _RIGHT = '<body name="leg_left" pos="0 0.1 0">', '<body name="leg_right" pos="0 -0.1 0">'
SMALL_TIED = (
    SMALL.replace('armature="0.01"', 'armature="0.01" frictionloss="0.1"')
    .replace('range="-40 40"', 'range="-8 8"')
    .replace('armature="0"', 'armature="0" frictionloss="0"')
    .replace(_LEFT, _LEFT + _TOE.format(x=0.2, y=-0.1))
    .replace(_RIGHT, _RIGHT + _TOE.format(x=0.31, y=0.1))
    .replace("  <actuator>", _LAWS)
)
_CONNECT = '<connect body1="heel_right" body2="foot_right" anchor="0 0 0"/>'
WELDED = TIED.replace(_CONNECT, '<weld body1="heel_right" body2="foot_right"/>')
TEXTS = {"welded": WELDED, "small": SMALL, "small, tied": SMALL_TIED, "tied": TIED}
