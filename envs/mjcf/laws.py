"""Writes what acts between a model's bodies: actuators, tendons, constraints, contacts, poses."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf.elements import GREY, SOLIMP, SOLREF, element, numbers, polynomial, unlike
from mjxwalk.envs.mjcf.kept import Kept

_TRANSMISSIONS: Mapping[int, str] = {
    int(mujoco.mjtTrn.mjTRN_JOINT): "joint",
    int(mujoco.mjtTrn.mjTRN_JOINTINPARENT): "jointinparent",
    int(mujoco.mjtTrn.mjTRN_TENDON): "tendon",
    int(mujoco.mjtTrn.mjTRN_SITE): "site",
    int(mujoco.mjtTrn.mjTRN_SLIDERCRANK): "cranksite",
    int(mujoco.mjtTrn.mjTRN_BODY): "body",
}


def contacts(kept: Kept) -> list[list[str]]:
    """Returns the elements of the pairs that collide and of the bodies that do not."""
    model = kept.model
    found: list[list[str]] = []
    for pair in kept.pairs:
        one, two = (
            model.geom(int(each[pair])).name for each in (model.pair_geom1, model.pair_geom2)
        )
        found.append(
            element(
                "pair",
                {
                    "name": model.pair(pair).name or None,
                    "geom1": one,
                    "geom2": two,
                    "condim": numbers(model.pair_dim[pair]),
                    "friction": numbers(model.pair_friction[pair]),
                    "solref": numbers(model.pair_solref[pair]),
                    "solimp": numbers(model.pair_solimp[pair]),
                    "margin": numbers(model.pair_margin[pair]),
                    "gap": numbers(model.pair_gap[pair]),
                    **unlike({"solreffriction": (model.pair_solreffriction[pair], (0, 0))}),
                },
            )
        )
    for exclude in range(model.nexclude):
        signature = int(model.exclude_signature[exclude])
        ends = [signature >> 16, signature & 0xFFFF]
        if all(each in kept.bodies or not each for each in ends):
            one, two = (kept.bodies.get(each, "world") for each in ends)
            found.append(element("exclude", {"body1": one, "body2": two}))
    return found


def tendons(kept: Kept) -> list[list[str]]:
    """Returns the elements of the tendons."""
    return [_tendon(kept, tendon) for tendon in kept.tendons]


def _tendon(kept: Kept, tendon: int) -> list[str]:
    model = kept.model
    first, num = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
    path = [_wrap(kept, wrap) for wrap in range(first, first + num)]
    fixed = int(model.wrap_type[first]) == int(mujoco.mjtWrap.mjWRAP_JOINT)
    attributes: dict[str, str | None] = {"name": model.tendon(tendon).name or None}
    if model.tendon_limited[tendon]:
        attributes["range"] = numbers(model.tendon_range[tendon])
    if model.tendon_actfrclimited[tendon]:
        attributes["actuatorfrcrange"] = numbers(model.tendon_actfrcrange[tendon])
    attributes |= unlike(
        {
            "springlength": (model.tendon_lengthspring[tendon], (-1, -1)),
            "stiffness": (
                polynomial(model.tendon_stiffness, model.tendon_stiffnesspoly, tendon),
                0,
            ),
            "damping": (polynomial(model.tendon_damping, model.tendon_dampingpoly, tendon), 0),
            "frictionloss": (model.tendon_frictionloss[tendon], 0),
            "armature": (model.tendon_armature[tendon], 0),
            "margin": (model.tendon_margin[tendon], 0),
            "group": (model.tendon_group[tendon], 0),
            "solreflimit": (model.tendon_solref_lim[tendon], SOLREF),
            "solimplimit": (model.tendon_solimp_lim[tendon], SOLIMP),
            "solreffriction": (model.tendon_solref_fri[tendon], SOLREF),
            "solimpfriction": (model.tendon_solimp_fri[tendon], SOLIMP),
        }
    )
    if not fixed:
        attributes |= unlike(
            {
                "width": (model.tendon_width[tendon], 0.003),
                "rgba": (model.tendon_rgba[tendon], GREY),
            }
        )
    return element("fixed" if fixed else "spatial", attributes, [line for e in path for line in e])


def _wrap(kept: Kept, wrap: int) -> list[str]:
    model = kept.model
    kind, place = int(model.wrap_type[wrap]), int(model.wrap_objid[wrap])
    number = float(model.wrap_prm[wrap])
    if kind == int(mujoco.mjtWrap.mjWRAP_JOINT):
        return element("joint", {"joint": kept.joints[place], "coef": numbers(number)})
    if kind == int(mujoco.mjtWrap.mjWRAP_PULLEY):
        return element("pulley", {"divisor": numbers(number)})
    if kind == int(mujoco.mjtWrap.mjWRAP_SITE):
        return element("site", {"site": model.site(place).name})
    side = model.site(int(number)).name if number >= 0 else None
    return element("geom", {"geom": model.geom(place).name, "sidesite": side})


def equalities(kept: Kept) -> list[list[str]]:
    """Returns the elements of the equality constraints."""
    return [_equality(kept, equality) for equality in kept.equalities]


def _equality(kept: Kept, equality: int) -> list[str]:
    model = kept.model
    kind = mujoco.mjtEq(int(model.eq_type[equality])).name.partition("_")[2].lower()
    ends = [int(each[equality]) for each in (model.eq_obj1id, model.eq_obj2id)]
    data = model.eq_data[equality]
    attributes: dict[str, str | None] = {"name": model.equality(equality).name or None}
    if kind in ("joint", "tendon"):
        names = [
            None if each < 0 else kept.joints[each] if kind == "joint" else model.tendon(each).name
            for each in ends
        ]
        attributes |= {f"{kind}1": names[0], f"{kind}2": names[1], "polycoef": numbers(data[:5])}
    elif int(model.eq_objtype[equality]) == int(mujoco.mjtObj.mjOBJ_SITE):
        attributes |= {f"site{place}": model.site(each).name for place, each in enumerate(ends, 1)}
    else:
        attributes |= {
            f"body{place}": kept.bodies.get(each, "world") for place, each in enumerate(ends, 1)
        }
        attributes["anchor"] = numbers(data[:3])
    if kind == "weld":
        if "body1" in attributes:
            attributes["relpose"] = numbers(data[3:10])
        attributes |= unlike({"torquescale": (data[10], 1)})
    if not model.eq_active0[equality]:
        attributes["active"] = "false"
    attributes |= unlike(
        {
            "solref": (model.eq_solref[equality], SOLREF),
            "solimp": (model.eq_solimp[equality], SOLIMP),
        }
    )
    return element(kind, attributes)


def actuators(kept: Kept) -> list[list[str]]:
    """Returns the elements of the actuators."""
    return [_actuator(kept, actuator) for actuator in kept.actuators]


def _actuator(kept: Kept, actuator: int) -> list[str]:
    model = kept.model
    attributes: dict[str, str | None] = {
        "name": model.actuator(actuator).name or None,
        **_target(kept, actuator),
    }
    for name in ("ctrl", "force", "act"):
        if getattr(model, f"actuator_{name}limited")[actuator]:
            attributes[f"{name}range"] = numbers(getattr(model, f"actuator_{name}range")[actuator])
    tag, law = _servo(model, actuator)
    attributes |= unlike(
        {
            "gear": (_shortened(model.actuator_gear[actuator], 1), 1),
            "group": (model.actuator_group[actuator], 0),
            "damping": (
                polynomial(model.actuator_damping, model.actuator_dampingpoly, actuator),
                0,
            ),
            "armature": (model.actuator_armature[actuator], 0),
            "cranklength": (model.actuator_cranklength[actuator], 0),
        }
    )
    return element(tag, {**attributes, **law})


def _target(kept: Kept, actuator: int) -> dict[str, str | None]:
    model = kept.model
    kind = _TRANSMISSIONS[int(model.actuator_trntype[actuator])]
    one, two = (int(each) for each in model.actuator_trnid[actuator][:2])
    if kind in ("joint", "jointinparent"):
        return {kind: kept.joints[one]}
    if kind == "tendon":
        return {kind: model.tendon(one).name}
    if kind == "body":
        return {kind: kept.bodies[one]}
    other = None if two < 0 else model.site(two).name
    if kind == "site":
        return {kind: model.site(one).name, "refsite": other}
    return {kind: model.site(one).name, "slidersite": other}


def _servo(model: Any, actuator: int) -> tuple[str, dict[str, str]]:
    """Returns the shortest element that has an actuator's law, and the law's attributes."""
    gain, bias = model.actuator_gainprm[actuator], model.actuator_biasprm[actuator]
    kinds = [
        kind(int(of[actuator])).name.partition("_")[2].lower()
        for kind, of in (
            (mujoco.mjtDyn, model.actuator_dyntype),
            (mujoco.mjtGain, model.actuator_gaintype),
            (mujoco.mjtBias, model.actuator_biastype),
        )
    ]
    plain = kinds[:2] == ["none", "fixed"] and not np.any(gain[1:])
    if plain and kinds[2] == "none" and gain[0] == 1.0 and not np.any(bias):
        return "motor", {}
    if plain and kinds[2] == "affine" and not np.any(bias[3:]):
        damping = {"kv": numbers(-bias[2])}
        if bias[0] == 0.0 and bias[1] == -gain[0] and bias[2] <= 0.0:
            return "position", {"kp": numbers(gain[0]), **damping}
        if bias[0] == bias[1] == 0.0 and bias[2] == -gain[0]:
            return "velocity", damping
    law = {"dyntype": kinds[0], "gaintype": kinds[1], "biastype": kinds[2]}
    law = {name: kind for name, kind in law.items() if kind not in ("none", "fixed")}
    dynamic = model.actuator_dynprm[actuator]
    for name, values in (("gainprm", gain), ("biasprm", bias), ("dynprm", dynamic)):
        law[name] = numbers(_shortened(values, 1))
    if model.actuator_actearly[actuator]:
        law["actearly"] = "true"
    if np.any(model.actuator_lengthrange[actuator]):
        law["lengthrange"] = numbers(model.actuator_lengthrange[actuator])
    return "general", law


def _shortened(values: Any, least: int) -> Any:
    """Returns numbers without the zeros that they end with, at least some of them."""
    last = np.flatnonzero(values)
    return values[: max(least, int(last[-1]) + 1 if len(last) else 0)]


def keys(kept: Kept) -> list[list[str]]:
    """Returns the elements of the keyframes."""
    model = kept.model
    qpos, qvel, act = kept.coordinates, kept.velocities, kept.activations
    return [
        element(
            "key",
            {
                "name": model.key(key).name or None,
                **unlike({"time": (model.key_time[key], 0)}),
                "qpos": _some(model.key_qpos[key], qpos),
                "qvel": _some(model.key_qvel[key], qvel, zero=True),
                "act": _some(model.key_act[key], act),
                "ctrl": _some(model.key_ctrl[key], kept.actuators, zero=True),
            },
        )
        for key in range(model.nkey)
    ]


def _some(values: Any, places: Sequence[int], *, zero: bool = False) -> str | None:
    """Returns those of the values; None if there are none, or all are zero as MuJoCo has it."""
    found = np.asarray(values)[list(places)]
    if not len(found) or (zero and not found.any()):
        return None
    return numbers(found)
