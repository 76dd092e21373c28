"""Small models with the features of MJX, and states to step them from."""

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

NUM_STATES = 12


@dataclasses.dataclass(frozen=True)
class Feature:
    """Features and a model that has them.

    Attributes:
      group: heading of the features.
      names: of the features.
      model: MJCF.
      height: of free bodies over the ground, which is varied by a fifth.
      refused: what MJX says of the feature, if it does not have it.
    """

    group: str
    names: tuple[str, ...]
    model: str
    height: float = 0.0
    refused: str = ""


def states(built: Any, height: float, seed: int = 0) -> tuple[Any, ...]:
    """Returns qpos, qvel, act and ctrl of some states of a model, in float64."""
    rng = np.random.default_rng(seed)
    qpos = np.tile(built.qpos0, (NUM_STATES, 1))
    qpos += rng.uniform(-0.1, 0.1, qpos.shape)
    for kind, start in zip(built.jnt_type, built.jnt_qposadr, strict=True):
        if kind == 0:  # free
            qpos[:, start : start + 2] *= 0.2
            qpos[:, start + 2] = height * rng.uniform(0.8, 1.0, NUM_STATES)
        if kind < 2:  # free and ball joints
            turn = qpos[:, start + 3 : start + 7] if kind == 0 else qpos[:, start : start + 4]
            turn /= np.linalg.norm(turn, axis=1, keepdims=True)
    qvel = rng.uniform(-1, 1, (NUM_STATES, built.nv))
    act = rng.uniform(0, 1, (NUM_STATES, built.na))
    return qpos, qvel, act, rng.uniform(-1, 1, (NUM_STATES, built.nu))


def _pendulum(option: str = "", inside: str = "", body: str = "", joint: str = "") -> str:
    """Returns two links over a plane, the second a hinge, with what a feature adds."""
    return f"""<mujoco>
      <option timestep="0.004" {option}/>
      <worldbody>
        <geom name="floor" type="plane" size="5 5 1"/>
        <site name="anchor" pos="0.2 0 0.6"/>
        <body name="first" pos="0 0 0.53"><joint name="slide" type="slide" axis="1 0 0"
            range="-0.05 0.05"/>
          <joint name="hip" axis="0 1 0" damping="0.1" {joint}/>
          <geom name="thigh" type="capsule" fromto="0 0 0 0 0 -0.25" size="0.04"/>
          <site name="thigh" pos="0.05 0 -0.1"/>{body}
          <body name="second" pos="0 0 -0.25"><joint name="knee" axis="0 1 0" range="-120 5"
              limited="true" stiffness="2"/>
            <geom name="shin" type="capsule" fromto="0 0 0 0 0 -0.25" size="0.04"/>
            <site name="foot" pos="0 0 -0.25" size="0.06"/></body></body>
      </worldbody>{inside}
    </mujoco>"""


def _pair(first: str, second: str, assets: str = "", option: str = "") -> str:
    """Returns a free geom over one that stands still."""
    return f"""<mujoco><option timestep="0.002" {option}/>{assets}
      <worldbody><geom name="still" {first}/>
        <body pos="0 0 1"><freejoint/><geom name="free" {second}/></body></worldbody></mujoco>"""


SPHERE, CAPSULE = 'type="sphere" size="0.1"', 'type="capsule" size="0.05 0.1"'
ELLIPSOID, CYLINDER = 'type="ellipsoid" size="0.1 0.08 0.12"', 'type="cylinder" size="0.1 0.08"'
BOX, MESH = 'type="box" size="0.1 0.08 0.06"', 'type="mesh" mesh="wedge"'
WEDGE = """<asset><mesh name="wedge" vertex="-.1 -.1 -.06  .1 -.1 -.06  -.1 .1 -.06
  .1 .1 -.06  0 0 .1"/></asset>"""
HILLS = """<asset><hfield name="hills" nrow="4" ncol="4" size="0.4 0.4 0.1 0.1"
  elevation="0 .2 .1 0  .3 .9 .6 .1  .2 .7 1 .2  0 .1 .3 0"/></asset>"""
PLANE = 'type="plane" size="5 5 1"'
HFIELD = 'type="hfield" hfield="hills"'

SHAPES = {"plane": (PLANE, 0.0), "hfield": (HFIELD, 0.05), "sphere": (SPHERE, 0.1),
          "capsule": (CAPSULE, 0.15), "ellipsoid": (ELLIPSOID, 0.12), "cylinder": (CYLINDER, 0.08),
          "box": (BOX, 0.06), "mesh": (MESH, 0.06)}  # fmt: skip
NO_PAIRS = {("hfield", "ellipsoid"), ("hfield", "cylinder"), ("ellipsoid", "box"),
            ("ellipsoid", "mesh"), ("cylinder", "box"), ("cylinder", "mesh")}  # fmt: skip


def _pairs() -> Iterator[Feature]:
    """Yields all pairs of shapes, also those that MJX does not have."""
    shapes = list(SHAPES)
    for place, first in enumerate(shapes):
        for second in shapes[max(place, 2) :]:
            (still, top), (free, bottom) = SHAPES[first], SHAPES[second]
            hills = HILLS if first == "hfield" else ""
            wedge = WEDGE if "mesh" in (first, second) else ""
            model = _pair(still, free, hills + wedge)
            names = (f"{first} and {second}",)
            refused = "collisions not implemented" if (first, second) in NO_PAIRS else ""
            yield Feature("Contacts", names, model, top + bottom, refused)


def _tendons(*texts: str) -> str:
    sensors = "".join(f'<tendonpos tendon="t{n}"/><tendonvel tendon="t{n}"/>'
                      for n in range(len(texts)))  # fmt: skip
    return _pendulum(
        inside=f"<tendon>{_numbered('t', texts)}</tendon><sensor>{sensors}</sensor>",
        body='<geom name="pulley" type="sphere" size="0.05" pos="0.1 0 -0.2" contype="0" '
        'conaffinity="0"/><geom name="drum" type="cylinder" size="0.04 0.1" pos="0.1 0 -0.2" '
        'euler="90 0 0" contype="0" conaffinity="0"/><site name="side" pos="0.2 0 -0.25"/>',
    )


def _numbered(name: str, texts: Sequence[str]) -> str:
    """Returns texts one after the other, what has a name in each with the text's number."""
    return "".join(text.replace(f'name="{name}"', f'name="{name}{n}"')
                   for n, text in enumerate(texts))  # fmt: skip


COUPLED = """<tendon><fixed name="t"><joint joint="hip" coef="0.5"/>
  <joint joint="knee" coef="-0.3"/></fixed>
  <fixed name="u"><joint joint="slide" coef="1"/></fixed></tendon>"""


def _equalities(*texts: str) -> str:
    return _pendulum(inside=f"{COUPLED}<equality>{''.join(texts)}</equality>")


def _actuators(*texts: str) -> str:
    sensors = "".join(f'<actuatorfrc actuator="a{n}"/>' for n in range(len(texts)))
    return _pendulum(inside=f"{COUPLED}<actuator>{_numbered('a', texts)}</actuator>"
                     f"<sensor>{sensors}</sensor>")  # fmt: skip


def _sensors(*texts: str) -> str:
    # MJX's rangefinder asks for a material.
    return _pendulum(
        inside=f'<asset><material name="grey"/></asset>{COUPLED}<actuator>'
        '<motor name="a" joint="hip"/><motor name="b" tendon="t"/>'
        f"</actuator><sensor>{''.join(texts)}</sensor>",
        option='magnetic="0 -0.5 0.2"',
        body='<camera name="eye" pos="0 -0.3 0" euler="90 0 0" resolution="32 32" fovy="60"/>'
        '<body name="head" pos="0 0 0.1"><joint name="neck" type="ball"/>'
        '<geom size="0.05" contype="0" conaffinity="0"/></body>',
    )


JOINTS = """<mujoco><worldbody><geom type="plane" size="5 5 1"/>
  <body pos="0 0 0.4"><freejoint/><geom size="0.1"/>
    <body pos="0.2 0 0"><joint type="ball" damping="0.1" stiffness="1" range="0 20"
        limited="true"/><geom type="box" size="0.1 0.02 0.03"/>
      <body pos="0.2 0 0"><joint type="hinge" axis="0 1 1" armature="0.01" frictionloss="0.1"/>
        <joint type="slide" axis="1 0 0" range="-0.02 0.02" limited="true"/>
        <geom type="capsule" size="0.03 0.05"/></body></body></body></worldbody></mujoco>"""

DIRECT = '<contact><pair geom1="floor" geom2="shin" friction="0.7 0.7 0.01 0 0"/></contact>'
FEW = '<custom><numeric name="max_contact_points" data="2"/></custom>'
FEWER = '<custom><numeric name="max_geom_pairs" data="1"/></custom>'
MOCAP = """<mujoco><worldbody><body name="hand" mocap="true" pos="0 0 0.5"/>
  <body name="held" pos="0 0 0.4"><freejoint/><geom size="0.1"/></body></worldbody>
  <equality><weld body1="hand" body2="held"/></equality></mujoco>"""
SPHERE_OF_CONDIM = """<body pos="{0} 0 0.1"><freejoint/><geom size="0.1" condim="{0}"
  friction="0.8 0.05 0.02"/></body>"""
SPHERES = f"""<mujoco><worldbody><geom type="plane" size="5 5 1" condim="1"/>
  {"".join(SPHERE_OF_CONDIM.format(number) for number in (1, 3, 4, 6))}</worldbody></mujoco>"""

OPTIONS = {
    "Integrators": {
        "Euler": "", "RK4": 'integrator="RK4"',
        "implicitfast": 'integrator="implicitfast"', "implicit": 'integrator="implicit"',
    },
    "Solvers": {
        "Newton, pyramidal cones, dense Jacobian": "", "CG": 'solver="CG"', "PGS": 'solver="PGS"',
        "one iteration, four of the line search": 'iterations="1" ls_iterations="4"',
        "elliptic cones": 'cone="elliptic"',
        "elliptic cones with CG": 'cone="elliptic" solver="CG" impratio="5"',
        "sparse Jacobian": 'jacobian="sparse"',
        "drag of a fluid": 'density="1000" viscosity="0.1" wind="0.5 0 0"',
    },
}  # fmt: skip

EQUALITIES = {
    "connect": '<connect body1="second" body2="world" anchor="0 0 -0.2"/>',
    "connect of sites": '<connect site1="foot" site2="anchor"/>',
    "weld": '<weld body1="second" body2="world" relpose="0 0 0.3 1 0 0 0"/>',
    "weld of sites": '<weld site1="foot" site2="anchor"/>',
    "joint": '<joint joint1="hip" joint2="knee" polycoef="0 0.5 0.1 0 0"/>',
    "joint alone": '<joint joint1="hip" polycoef="0.1"/>',
    "tendon": '<tendon tendon1="t" tendon2="u" polycoef="0 1 0 0 0"/>',
    "inactive": '<joint joint1="hip" active="false"/>',
}

SITES = '<site site="anchor"/><site site="thigh"/><site site="foot"/>'
TENDONS = {
    "fixed": '<fixed name="t"><joint joint="hip" coef="0.5"/><joint joint="knee" coef="1"/>'
    "</fixed>",
    "through sites": f'<spatial name="t" stiffness="5" damping="1">{SITES}</spatial>',
    "around a sphere": '<spatial name="t" stiffness="5" springlength="0.1"><site site="anchor"/>'
    '<geom geom="pulley" sidesite="side"/><site site="foot"/></spatial>',
    "around a cylinder": '<spatial name="t" stiffness="5"><site site="anchor"/>'
    '<geom geom="drum" sidesite="side"/><site site="foot"/></spatial>',
    "with a pulley": '<spatial name="t" stiffness="5"><site site="anchor"/><site site="thigh"/>'
    '<pulley divisor="2"/><site site="thigh"/><site site="foot"/></spatial>',
    "limit": f'<spatial name="t" limited="true" range="0 0.5">{SITES}</spatial>',
    "friction": f'<spatial name="t" frictionloss="0.5">{SITES}</spatial>',
    "armature": f'<spatial name="t" armature="0.2">{SITES}</spatial>',
    "dead band": f'<spatial name="t" stiffness="5" springlength="0.1 0.3">{SITES}</spatial>',
}

ACTUATORS = {
    "motor": '<motor name="a" joint="hip" gear="30" ctrllimited="true" ctrlrange="-0.5 0.5"/>',
    "position": '<position name="a" joint="hip" kp="20" kv="1"/>',
    "velocity": '<velocity name="a" joint="hip" kv="3"/>',
    "intvelocity": '<intvelocity name="a" joint="hip" kp="5" actrange="-1 1"/>',
    "damper": '<damper name="a" joint="hip" kv="3" ctrlrange="0 1"/>',
    "cylinder": '<cylinder name="a" joint="hip" timeconst="0.1" area="0.5"/>',
    "muscle": '<muscle name="a" tendon="t" force="20" lengthrange="0.1 1"/>',
    "filter": '<general name="a" joint="hip" dyntype="filter" dynprm="0.1" gainprm="5"/>',
    "exact filter": '<general name="a" joint="hip" dyntype="filterexact" dynprm="0.1"/>',
    "integrator": '<general name="a" joint="hip" dyntype="integrator" actearly="true"/>',
    "range of force": '<motor name="a" joint="hip" gear="5" forcerange="-0.2 0.2"/>',
    "on a tendon": '<motor name="a" tendon="t" gear="5"/>',
    "on a site": '<motor name="a" site="foot" gear="1 0 2 0 0.5 0"/>',
    "on a site, from another": '<motor name="a" site="foot" refsite="anchor" gear="1 0 2 0 0 0"/>',
    "on a joint, in its parent": '<motor name="a" jointinparent="knee"/>',
    "slider and crank": '<motor name="a" cranksite="thigh" slidersite="foot" cranklength="0.2"/>',
    "adhesion": '<adhesion name="a" body="second" ctrlrange="0 1" gain="3"/>',
}

SENSORS = {
    "touch": '<touch site="foot"/>', "accelerometer": '<accelerometer site="foot"/>',
    "velocimeter": '<velocimeter site="foot"/>', "gyro": '<gyro site="foot"/>',
    "force": '<force site="foot"/>', "torque": '<torque site="foot"/>',
    "magnetometer": '<magnetometer site="foot"/>', "rangefinder": '<rangefinder site="foot"/>',
    "camera projection": '<camprojection site="foot" camera="eye"/>',
    "joints": '<jointpos joint="hip"/><jointvel joint="hip"/><jointactuatorfrc joint="hip"/>',
    "limits of joints": '<jointlimitpos joint="knee"/><jointlimitfrc joint="knee"/>',
    "tendons": '<tendonpos tendon="t"/><tendonvel tendon="t"/><tendonactuatorfrc tendon="t"/>',
    "actuators": '<actuatorpos actuator="a"/><actuatorvel actuator="a"/>'
    '<actuatorfrc actuator="b"/>',
    "ball joints": '<ballquat joint="neck"/><ballangvel joint="neck"/>',
    "places of frames": '<framepos objtype="body" objname="second"/><framequat objtype="geom" '
    'objname="shin"/><framexaxis objtype="site" objname="foot"/><frameyaxis objtype="site" '
    'objname="foot" reftype="body" refname="first"/><framezaxis objtype="xbody" objname="second"/>',
    "velocities of frames": '<framelinvel objtype="body" objname="second"/><frameangvel '
    'objtype="site" objname="foot" reftype="body" refname="first"/>',
    "accelerations of frames": '<framelinacc objtype="body" objname="second"/>'
    '<frameangacc objtype="site" objname="foot"/>',
    "subtrees": '<subtreecom body="first"/><subtreelinvel body="first"/>'
    '<subtreeangmom body="first"/>',
    "clock": "<clock/>",
    "contacts": '<contact geom1="floor" geom2="shin" num="1" data="found force dist pos normal"/>',
    "distance of geoms": '<distance geom1="floor" geom2="shin" cutoff="1"/>',
    "energy": "<e_potential/><e_kinetic/>",
}  # fmt: skip


REFUSED = {
    "implicit": "mjINT_IMPLICIT", "PGS": "mjSOL_PGS", "slider and crank": "mjTRN_SLIDERCRANK",
    "adhesion": "mjTRN_BODY", "limits of joints": "mjSENS_JOINTLIMITPOS",
    "distance of geoms": "mjSENS_GEOMDIST", "energy": "mjSENS_E_POTENTIAL",
}  # fmt: skip


def _all() -> Iterator[Feature]:
    for group, options in OPTIONS.items():
        for name, option in options.items():
            yield Feature(group, (name,), _pendulum(option), refused=REFUSED.get(name, ""))
    explicit = _pendulum(inside='<option><flag eulerdamp="disable"/></option>')
    yield Feature("Integrators", ("Euler without implicit damping",), explicit)
    yield Feature("Contacts", ("1, 3, 4 and 6 dimensions",), SPHERES, 0.1)
    yield Feature("Contacts", ("pairs by name",), _pendulum(inside=DIRECT))
    yield Feature("Contacts", ("max_contact_points",), _pendulum(inside=FEW))
    yield Feature("Contacts", ("max_geom_pairs",), _pendulum(inside=FEWER))
    yield from _pairs()
    joints = "free", "ball", "hinge", "slide", "limits", "springs", "friction", "armature"
    yield Feature("Joints", joints, JOINTS, 0.4)
    light = _pendulum().replace('<body name="second"', '<body name="second" gravcomp="0.8"')
    yield Feature("Joints", ("gravity compensation",), light)
    yield Feature("Joints", ("bodies that are moved by hand (mocap)",), MOCAP, 0.45)
    for group, texts, build in (
        ("Equalities", EQUALITIES, _equalities), ("Tendons", TENDONS, _tendons),
        ("Actuators", ACTUATORS, _actuators), ("Sensors", SENSORS, _sensors),
    ):  # fmt: skip
        known = {name: text for name, text in texts.items() if name not in REFUSED}
        yield Feature(group, tuple(known), build(*known.values()))
        for name in [name for name in texts if name in REFUSED]:
            yield Feature(group, (name,), build(texts[name]), refused=REFUSED[name])


FEATURES = tuple(_all())
