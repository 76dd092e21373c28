"""Bodies that users bring as MJCF: what a file must hold, and what is refused.

A body is simulated by our own equations, not by MuJoCo's solver; so what these do not have is
refused, each with what to do about it, rather than left out in silence. `docs/body.md` tells users.
"""

import functools
from typing import Any

import numpy as np

from mjxwalk.envs import body_legs, body_xml
from mjxwalk.envs._mujoco import compiled, mjx, mujoco, refusing
from mjxwalk.envs.anatomy import HINGE, SLIDE
from mjxwalk.envs.body_contract import Contract, Link

CLOSE = 1e-6  # of m, kg, rad; ours: what MuJoCo's own writer rounds to

KINDS = {
    int(mujoco.mjtJoint.mjJNT_FREE): "free joint",
    int(mujoco.mjtJoint.mjJNT_BALL): "ball joint",
    SLIDE: "slide",
    HINGE: "hinge",
}
# s; ours: of the step in <option>, which is not the one that is taken but is to be one
SHORTEST_STEP, LONGEST_STEP = 1e-6, 1.0
# Flags of MuJoCo's solver that mean something to the engines.
_ALWAYS = tuple(
    f"mjDSBL_{name}"
    for name in ("GRAVITY", "ACTUATION", "SPRING", "DAMPER", "FRICTIONLOSS", "CLAMPCTRL")
)
_NEVER = ("mjENBL_OVERRIDE",)


def read(text: str) -> Any:
    """Returns the `mujoco.MjSpec` of a body's XML.

    Raises:
      ValueError: it holds what no body may, or MuJoCo cannot read it.
    """
    xml = body_xml.checked(text)
    with refusing("MuJoCo cannot read it"):
        return mujoco.MjSpec.from_string(xml)


def check(text: str, contract: Contract) -> None:
    """Returns if a body's XML can be simulated.

    Raises:
      ValueError: it cannot; the message names what, and says what to do.
    """
    complaint = _complaint(text, contract)
    if complaint:
        raise ValueError(complaint)


# A run builds its settings again and again.
@functools.lru_cache(maxsize=16)
def _complaint(text: str, contract: Contract) -> str:
    try:
        model = compiled(read(text))
        _check_finite(model)
        check_world(model, contract)
        _check_links(model, contract)
        for name, body in contract.sites:
            _check_site(model, name, body)
        body_legs.check_joints(model, contract)
        body_legs.check_motors(model, contract)
        body_legs.check_mirrored(model, contract, CLOSE)
        with refusing(f"MJX cannot simulate the {contract.kind} body"):
            mjx.put_model(model)
    except ValueError as error:
        return str(error)
    return ""


def _check_finite(model: Any) -> None:
    """Raises ValueError unless all that MuJoCo has made of the file's numbers are numbers."""
    for name in ("body", "jnt", "dof", "geom", "site", "actuator", "qpos"):
        for field in (each for each in dir(model) if each.startswith(name)):
            values = getattr(model, field)
            if isinstance(values, np.ndarray) and not np.isfinite(values).all():
                raise ValueError(f"has numbers that make MuJoCo's {field} no number; change them")


def check_world(model: Any, contract: Contract) -> None:
    """Raises ValueError unless what is not of the tree can be simulated."""
    for equality in range(model.neq):
        _check_equality(model, equality, contract)
    for tendon in range(model.ntendon):
        name = model.tendon(tendon).name or f"number {tendon}"
        raise ValueError(f"has the tendon {name}, and the engines have none; remove it")
    for pair in range(model.npair):
        one, two = (
            model.geom(int(geom[pair])).name for geom in (model.pair_geom1, model.pair_geom2)
        )
        raise ValueError(
            f"has a <pair> by which the geoms {one} and {two} would collide, and here only sites "
            "touch the ground; remove it"
        )
    for key in range(model.nkey):
        name = model.key(key).name or f"number {key}"
        raise ValueError(
            f"has the keyframe {name}, and a trial puts the body on the ground by itself; remove it"
        )
    option = model.opt
    _check_flags(option)
    if not SHORTEST_STEP <= option.timestep <= LONGEST_STEP:
        raise ValueError(
            f"has timestep {option.timestep:g} in <option>; leave it out, as walkers take steps of "
            "env.timestep"
        )
    if not np.allclose(option.gravity, [0.0, 0.0, -9.81]):
        raise ValueError(
            f"has gravity {_numbers(option.gravity)}, and walkers walk under 0 0 -9.81; set "
            "gravity in <option> to that, or leave it out"
        )
    if int(option.integrator) != int(mujoco.mjtIntegrator.mjINT_EULER):
        name = mujoco.mjtIntegrator(int(option.integrator)).name.removeprefix("mjINT_")
        raise ValueError(
            f"has the integrator {name}, and the engines have their own; leave integrator out of "
            "<option>, and choose by --set env.integrator=implicit or explicit"
        )
    if option.density or option.viscosity or np.any(option.wind):
        raise ValueError("has air or water (density, viscosity, wind); leave them out of <option>")
    for geom in range(model.ngeom):
        if model.geom_bodyid[geom] and (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            name = model.geom(geom).name or f"number {geom}"
            raise ValueError(
                f"geom {name} of body {model.body(model.geom_bodyid[geom]).name} would collide, "
                f"and here only the sites {', '.join(dict(contract.sites))} touch the ground; set "
                'contype="0" conaffinity="0", for all in <default><geom .../></default>'
            )


def _check_flags(option: Any) -> None:
    """Raises ValueError if the file turns off or on what the engines always, or never, have."""
    for kinds, bits, names, word in (
        (mujoco.mjtDisableBit, option.disableflags, _ALWAYS, "disables"),
        (mujoco.mjtEnableBit, option.enableflags, _NEVER, "enables"),
    ):
        for name in names:
            if int(bits) & int(getattr(kinds, name)):
                flag = name.partition("_")[2].lower()
                raise ValueError(f"{word} {flag}; leave that flag out of <option>")


def _check_equality(model: Any, equality: int, contract: Contract) -> None:
    ends = {
        str(model.joint(int(each[equality])).name)
        for each in (model.eq_obj1id, model.eq_obj2id)
        if int(model.eq_type[equality]) == int(mujoco.mjtEq.mjEQ_JOINT) and each[equality] >= 0
    }
    equal = np.allclose(model.eq_data[equality][:5], [0.0, 1.0, 0.0, 0.0, 0.0])
    if contract.tied is None or ends != set(contract.tied) or not equal:
        name = model.equality(equality).name or f"number {equality}"
        raise ValueError(
            f"has the equality constraint {name}, which the {contract.kind} body cannot have; "
            "remove it"
        )


def _check_links(model: Any, contract: Contract) -> None:
    """Checks the bodies, how they hang together, and which joints they have."""
    names = [str(model.body(i).name) for i in range(model.nbody)]
    for link in contract.links:
        if link.name not in names:
            raise ValueError(
                f"has no body {link.name}; the {contract.kind} body needs "
                f"{', '.join(each.name for each in contract.links)}"
            )
        body = names.index(link.name)
        parent = names[int(model.body_parentid[body])]
        if parent != link.parent:
            raise ValueError(f"body {link.name} must be inside {link.parent}, and is in {parent}")
        _check_link(model, body, link)
    known = {link.name for link in contract.links}
    for body in range(1, model.nbody):
        name = names[body] or f"number {body}"
        if int(model.body_parentid[body]) == 0 and name not in known:
            raise ValueError(f"body {name} lies beside {contract.links[0].name}; remove it")
        if name not in known and model.body_jntnum[body]:
            joint = model.joint(int(model.body_jntadr[body])).name or "without a name"
            raise ValueError(
                f"body {name} has a joint ({joint}), and the {contract.kind} body has those of "
                f"{', '.join(sorted(known))} only; remove the joint, which fixes {name} to its "
                "parent"
            )
        if not np.allclose(model.body_quat[body], [1.0, 0.0, 0.0, 0.0]):
            raise ValueError(
                f"body {name} is turned (quat {_numbers(model.body_quat[body])}); leave its axes "
                "along the world's, and turn its geoms or its inertia instead"
            )
        if model.body_gravcomp[body]:
            raise ValueError(f"body {name} has gravcomp; remove it")


def _check_link(model: Any, body: int, link: Link) -> None:
    first, num = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    found = [model.joint(joint) for joint in range(first, first + num)]
    expected = ", ".join(f"{each.name} ({KINDS[each.kind]})" for each in link.joints) or "none"
    has = ", ".join(f"{j.name or 'no name'} ({KINDS[int(j.type[0])]})" for j in found) or "none"
    if [(j.name, int(j.type[0])) for j in found] != [(j.name, j.kind) for j in link.joints]:
        raise ValueError(
            f"body {link.name} must have the joints {expected}, in this order, and has {has}"
        )
    for joint, due in zip(found, link.joints, strict=True):
        if not np.allclose(joint.axis, due.axis, atol=CLOSE):
            raise ValueError(
                f"joint {due.name} turns about or moves along {_numbers(joint.axis)}, and must "
                f'about or along axis="{_numbers(due.axis)}", so that its sign means the same'
            )
        if np.any(joint.pos):
            raise ValueError(
                f"joint {due.name} has pos {_numbers(joint.pos)}, and must be at its body's "
                "origin; move the body there"
            )
    x, y, z = model.body_pos[body]
    if link.parent == "world" and max(abs(x), abs(y), abs(z)) > 0.0:
        raise ValueError(
            f"body {link.name} must have pos 0 0 0, between the hips, and has "
            f"{_numbers((x, y, z))}; a trial puts it on the ground by itself"
        )
    if link.hangs is not None and (abs(x) > CLOSE or (z >= 0.0 if link.hangs else abs(z) > CLOSE)):
        where = "straight below" if link.hangs else "at the height of, and not ahead of"
        raise ValueError(
            f"body {link.name} lies at {_numbers((x, y, z))}, and must lie {where} {link.parent} "
            "(x is 0), since with all angles zero the body stands upright"
        )


def _check_site(model: Any, name: str, body: str) -> None:
    sites = [str(model.site(i).name) for i in range(model.nsite)]
    if name not in sites:
        raise ValueError(
            f"has no site {name}, where {body} touches the ground; add <site name="
            f'"{name}" pos="..."/> to it'
        )
    found = str(model.body(int(model.site_bodyid[sites.index(name)])).name)
    if found != body:
        raise ValueError(f"site {name} must be on body {body}, and is on {found}")


def _numbers(values: Any) -> str:
    return " ".join(f"{value:.6g}" for value in np.asarray(values, np.float64))
