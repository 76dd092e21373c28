"""Sentences about a user's file: what of it is left out, and what replaces it."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf.kept import Kept
from mjxwalk.envs.mjcf.lines import Place, one_of

_HOLDING = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))
_RANGES = ("range", "ctrlrange", "forcerange", "actuatorfrcrange")
_SHOWN = 3  # names of a list; the rest are counted


def listed(word: str, names: Sequence[str], verb: str, verbs: str) -> str:
    """Returns the subject and verb of a sentence about one thing or many.

    Args:
      word: what they are, one of them.
      names: of them; those without one are empty.
      verb: of one.
      verbs: of many.
    """
    known = [name for name in dict.fromkeys(names) if name]
    if len(names) == 1:
        return f"{word} {names[0]} {verb}" if known else f"a {word} without a name {verb}"
    many = f"{word[:-1]}ies" if word.endswith("y") else f"{word}s"
    if not known:
        return f"{len(names)} {many} {verbs}"
    if len(known) == 1:
        return f"{word} {known[0]} {verb}"
    shown, rest = known[:_SHOWN], len(names) - _SHOWN
    if rest > 1:
        return f"{many} {', '.join(shown)} and {rest} more {verbs}"
    return f"{many} {', '.join(known[:-1])} and {known[-1]} {verbs}"


def said(text: str, place: Place | None = None) -> str:
    """Returns a sentence of a text, with the line that it is about."""
    where = f"{place}: " if place else ""
    whole = f"{where}{text}"
    return f"{whole[0].upper()}{whole[1:]}."


def of_points(kept: Kept, places: Sequence[Place]) -> tuple[str, ...]:
    """Returns what contact law `points` leaves out of a body or replaces, as sentences."""
    model = kept.model
    return (
        *_of_options(model, places),
        *_of_joints(kept, places),
        *_of_constraints(kept, places),
        *_of_actuators(kept, places),
    )


def _of_options(model: Any, places: Sequence[Place]) -> list[str]:
    given, plain, found = model.opt, mujoco.MjOption(), list[str]()

    def place(attribute: str) -> Place | None:
        written = [each for each in places if each.tag == "option" and attribute in each.attributes]
        return written[-1] if written else None

    def word(kind: Any, value: int) -> str:
        return str(kind(value).name).partition("_")[2]

    if given.integrator != plain.integrator:
        name = word(mujoco.mjtIntegrator, int(given.integrator))
        text = f"the integrator {name} is replaced by semi-implicit Euler with implicit contacts"
        found.append(said(text, place("integrator")))
    if given.solver != plain.solver:
        name = word(mujoco.mjtSolver, int(given.solver))
        text = f"the solver {name} is not needed; contact law points has springs and dampers"
        found.append(said(text, place("solver")))
    for attribute, what in (
        ("density", "the medium's density"),
        ("viscosity", "the medium's viscosity"),
        ("wind", "the wind"),
    ):
        if np.any(getattr(given, attribute)):
            found.append(said(f"{what} is left out", place(attribute)))
    return found


def _of_joints(kept: Kept, places: Sequence[Place]) -> list[str]:
    model, found = kept.model, list[str]()
    inner = [joint for joint in kept.joints if int(model.jnt_bodyid[joint]) not in kept.roots]
    dofs = {joint: int(model.jnt_dofadr[joint]) for joint in inner}
    cases: tuple[tuple[str, str, Callable[[int], Any]], ...] = (
        (
            "is taken as three hinges, about z, y and x",
            "are taken as three hinges each, about z, y and x",
            lambda joint: int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_BALL),
        ),
        (
            "has a spring or damper that is linear from here on",
            "have springs or dampers that are linear from here on",
            lambda joint: (
                np.any(model.jnt_stiffnesspoly[joint]) or np.any(model.dof_dampingpoly[dofs[joint]])
            ),
        ),
    )
    for verb, verbs, holds in cases:
        names = [kept.joints[joint] for joint in inner if holds(joint)]
        if names:
            place = one_of(places, name=names[0]) if len(names) == 1 else None
            found.append(said(listed("joint", names, verb, verbs), place))
    found += _of_ranges(places)
    light = [name for body, name in kept.bodies.items() if model.body_gravcomp[body]]
    if light:
        found.append(said(listed("body", light, "weighs", "weigh") + " all it has (no gravcomp)"))
    return found


def _of_ranges(places: Sequence[Place]) -> list[str]:
    """Returns which ranges MuJoCo does not take, as they end before they begin."""
    found: dict[tuple[str, str], list[Place]] = {}
    for place in places:
        for attribute in _RANGES:
            words = place.attributes.get(attribute, "").split()
            try:
                lower, upper = (float(word) for word in words)
            except ValueError:  # none, or MuJoCo has said what is wrong
                continue
            if upper < lower:
                found.setdefault((attribute, place.tag), []).append(place)
    return [
        said(
            f"{attribute} of "
            + listed(tag, [each.attributes.get("name", "") for each in wrong], "", "").strip()
            + " ends before it begins, and limits nothing",
            wrong[0] if len(wrong) == 1 else None,
        )
        for (attribute, tag), wrong in found.items()
    ]


def _of_constraints(kept: Kept, places: Sequence[Place]) -> list[str]:
    model, found = kept.model, list[str]()
    tendons = [str(model.tendon(each).name) for each in kept.tendons]
    if tendons:
        place = one_of(places, name=tendons[0]) if len(tendons) == 1 and tendons[0] else None
        found.append(
            said(
                listed("tendon", tendons, "is", "are")
                + " left out, springs and limits too; contact law points has none",
                place,
            )
        )
    held = [
        str(model.equality(each).name)
        for each in kept.equalities
        if int(model.eq_type[each]) in _HOLDING and model.eq_active0[each]
    ]
    if held:
        text = listed("constraint", held, "holds nothing together", "hold nothing together")
        place = one_of(places, name=held[0]) if len(held) == 1 and held[0] else None
        found.append(said(f"{text}; contact law points has no <connect> and <weld>", place))
    joints = int(mujoco.mjtEq.mjEQ_JOINT)
    coupled = [
        kept.joints[int(model.eq_obj1id[each])]
        for each in kept.equalities
        if int(model.eq_type[each]) == joints and model.eq_active0[each]
    ]
    if coupled:
        text = listed("joint", coupled, "moves by itself", "move by themselves")
        found.append(said(f"{text}, as contact law points couples no joints (<equality>)"))
    return found


def _of_actuators(kept: Kept, places: Sequence[Place]) -> list[str]:
    model = kept.model
    lagging = [
        str(model.actuator(each).name)
        for each in kept.actuators
        if int(model.actuator_dyntype[each]) not in (0, int(mujoco.mjtDyn.mjDYN_MUSCLE))
    ]
    pushing = [
        str(model.actuator(each).name)
        for each in kept.actuators
        if int(model.actuator_biastype[each]) == int(mujoco.mjtBias.mjBIAS_AFFINE)
        and model.actuator_biasprm[each][0]
    ]
    cases = (
        (lagging, "acts at once", "act at once", "has no activation (dyntype)"),
        (pushing, "does not push", "do not push", "has no constant force (biasprm)"),
    )
    return [
        said(f"{listed('actuator', names, verb, verbs)}; contact law points {why}", place)
        for names, verb, verbs, why in cases
        if names
        for place in [one_of(places, name=names[0]) if len(names) == 1 and names[0] else None]
    ]
