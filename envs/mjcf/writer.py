"""Writes a compiled model as one MJCF text that refers to no other file.

Every value is written as the compiled model holds it, with all its digits: includes, classes,
frames, units and ways to turn are resolved by then. What only decorates is not written.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import laws, options
from mjxwalk.envs.mjcf.elements import (
    GREY,
    SOLIMP,
    SOLREF,
    element,
    numbers,
    polynomial,
    section,
    unlike,
)
from mjxwalk.envs.mjcf.kept import Kept

# How many numbers say the size of a shape.
SHAPES: Mapping[int, tuple[str, int]] = {
    int(mujoco.mjtGeom.mjGEOM_PLANE): ("plane", 3),
    int(mujoco.mjtGeom.mjGEOM_SPHERE): ("sphere", 1),
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): ("capsule", 2),
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): ("ellipsoid", 3),
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): ("cylinder", 2),
    int(mujoco.mjtGeom.mjGEOM_BOX): ("box", 3),
}
JOINTS: Mapping[int, str] = {
    int(mujoco.mjtJoint.mjJNT_FREE): "free",
    int(mujoco.mjtJoint.mjJNT_BALL): "ball",
    int(mujoco.mjtJoint.mjJNT_SLIDE): "slide",
    int(mujoco.mjtJoint.mjJNT_HINGE): "hinge",
}


class Shape(NamedTuple):
    """What a geom of a mesh is written as.

    Attributes:
      kind: of MuJoCo's shapes; `mesh` for the vertices of a hull.
      size: in the numbers that this kind has, m.
      pos: in the body, m.
      quat: in the body.
      mesh: name of the hull; empty for other kinds.
    """

    kind: str
    size: tuple[float, ...]
    pos: Any
    quat: Any
    mesh: str = ""


def text(
    kept: Kept, shapes: Mapping[int, Shape], hulls: Mapping[str, Any], more: Mapping[str, Any]
) -> str:
    """Returns the MJCF of the kept part of a model.

    Args:
      kept: the model, and which parts of it are written under which names.
      shapes: of the geoms that are meshes in the model; those not in it are left out.
      hulls: vertices of each mesh that shapes name, m.
      more: lines that are added to sections, by the section's name.
    """
    model = kept.model
    meshes = [
        element("mesh", {"name": name, "vertex": numbers(np.ravel(vertices))})
        for name, vertices in hulls.items()
    ]
    lines = element(
        "mujoco",
        {"model": str(model.names[: model.names.index(b"\0")].decode()) or None},
        [
            *element("compiler", {"angle": "radian", "inertiafromgeom": "false"}),
            *options.option(model),
            *options.statistic(kept),
            *section("asset", meshes),
            *section(
                "worldbody",
                [
                    *(_geom(kept, geom, shapes) for geom in kept.floors),
                    *(_body(kept, body, shapes) for body in kept.roots),
                ],
            ),
            *section("contact", laws.contacts(kept)),
            *section("tendon", laws.tendons(kept)),
            *section("equality", laws.equalities(kept)),
            *section("actuator", [*laws.actuators(kept), *more.get("actuator", ())]),
            *section("keyframe", laws.keys(kept)),
        ],
    )
    return "\n".join(lines) + "\n"


def _body(kept: Kept, body: int, shapes: Mapping[int, Shape]) -> list[str]:
    model = kept.model
    inside: list[str] = []
    if model.body_mass[body] > 0.0:
        inside += element(
            "inertial",
            {
                "pos": numbers(model.body_ipos[body]),
                **unlike({"quat": (model.body_iquat[body], (1, 0, 0, 0))}),
                "mass": numbers(model.body_mass[body]),
                "diaginertia": numbers(model.body_inertia[body]),
            },
        )
    first, num = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    for joint in range(first, first + num):
        inside += _joint(kept, joint)
    first, num = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    for geom in range(first, first + num):
        inside += _geom(kept, geom, shapes)
    for site in np.flatnonzero(model.site_bodyid == body):
        inside += _site(kept, int(site))
    for child in np.flatnonzero(model.body_parentid == body):
        if child in kept.bodies:
            inside += _body(kept, int(child), shapes)
    return element(
        "body",
        {
            "name": kept.bodies[body],
            **unlike(
                {
                    "pos": (model.body_pos[body], (0, 0, 0)),
                    "quat": (model.body_quat[body], (1, 0, 0, 0)),
                    "gravcomp": (model.body_gravcomp[body], 0),
                }
            ),
        },
        inside,
    )


def _joint(kept: Kept, joint: int) -> list[str]:
    model = kept.model
    kind = JOINTS[int(model.jnt_type[joint])]
    dof, place = int(model.jnt_dofadr[joint]), int(model.jnt_qposadr[joint])
    attributes: dict[str, str | None] = {"name": kept.joints[joint], "type": kind}
    if kind in ("slide", "hinge"):
        attributes["axis"] = numbers(model.jnt_axis[joint])
        attributes |= unlike(
            {"ref": (model.qpos0[place], 0), "springref": (model.qpos_spring[place], 0)}
        )
    if model.jnt_limited[joint]:
        attributes["range"] = numbers(model.jnt_range[joint])
    if model.jnt_actfrclimited[joint]:
        attributes["actuatorfrcrange"] = numbers(model.jnt_actfrcrange[joint])
    if model.jnt_actgravcomp[joint]:
        attributes["actuatorgravcomp"] = "true"
    attributes |= unlike(
        {
            "pos": (model.jnt_pos[joint] * (kind != "free"), (0, 0, 0)),
            "stiffness": (polynomial(model.jnt_stiffness, model.jnt_stiffnesspoly, joint), 0),
            "damping": (polynomial(model.dof_damping, model.dof_dampingpoly, dof), 0),
            "armature": (model.dof_armature[dof], 0),
            "frictionloss": (model.dof_frictionloss[dof], 0),
            "margin": (model.jnt_margin[joint], 0),
            "group": (model.jnt_group[joint], 0),
            "solreflimit": (model.jnt_solref[joint], SOLREF),
            "solimplimit": (model.jnt_solimp[joint], SOLIMP),
            "solreffriction": (model.dof_solref[dof], SOLREF),
            "solimpfriction": (model.dof_solimp[dof], SOLIMP),
        }
    )
    return element("joint", attributes)


def _geom(kept: Kept, geom: int, shapes: Mapping[int, Shape]) -> list[str]:
    model = kept.model
    kind = int(model.geom_type[geom])
    if geom in shapes:
        shape = shapes[geom]
    elif kind in SHAPES:
        name, num = SHAPES[kind]
        size = tuple(model.geom_size[geom][:num])
        shape = Shape(name, size, model.geom_pos[geom], model.geom_quat[geom])
    else:
        return []
    attributes: dict[str, str | None] = {
        "name": model.geom(geom).name or None,
        "type": shape.kind,
        "size": numbers(shape.size) if shape.size else None,
        "mesh": shape.mesh or None,
        **unlike({"pos": (shape.pos, (0, 0, 0)), "quat": (shape.quat, (1, 0, 0, 0))}),
        "rgba": colour(model, geom),
        **unlike(
            {
                "group": (model.geom_group[geom], 0),
                "contype": (model.geom_contype[geom], 1),
                "conaffinity": (model.geom_conaffinity[geom], 1),
            }
        ),
    }
    if geom in kept.colliding:
        attributes |= _surface(model, geom)
    if model.geom_fluid[geom][0]:
        attributes["fluidshape"] = "ellipsoid"
        attributes["fluidcoef"] = numbers(model.geom_fluid[geom][1:6])
    return element("geom", attributes)


def _surface(model: Any, geom: int) -> dict[str, str]:
    return unlike(
        {
            "condim": (model.geom_condim[geom], 3),
            "priority": (model.geom_priority[geom], 0),
            "friction": (model.geom_friction[geom], (1.0, 0.005, 0.0001)),
            "solmix": (model.geom_solmix[geom], 1),
            "solref": (model.geom_solref[geom], SOLREF),
            "solimp": (model.geom_solimp[geom], SOLIMP),
            "margin": (model.geom_margin[geom], 0),
            "gap": (model.geom_gap[geom], 0),
        }
    )


def colour(model: Any, geom: int) -> str | None:
    """Returns the colour of a geom, its material's where it has none of its own."""
    found = model.geom_rgba[geom]
    material = int(model.geom_matid[geom])
    if material >= 0 and np.allclose(found, GREY):
        found = model.mat_rgba[material]
    return None if np.allclose(found, GREY) else numbers(found)


def _site(kept: Kept, site: int) -> list[str]:
    model = kept.model
    name, num = SHAPES.get(int(model.site_type[site]), ("sphere", 1))
    return element(
        "site",
        {
            "name": model.site(site).name or None,
            **({} if name == "sphere" else {"type": name}),
            **unlike(
                {
                    "size": (model.site_size[site][:num], (0.005,)),
                    "pos": (model.site_pos[site], (0, 0, 0)),
                    "quat": (model.site_quat[site], (1, 0, 0, 0)),
                    "group": (model.site_group[site], 0),
                    "rgba": (model.site_rgba[site], GREY),
                }
            ),
        },
    )
