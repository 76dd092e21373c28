"""Takes out of a file what it names and does not have, where a body does not need it."""

import math
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import lines
from mjxwalk.envs.mjcf.lines import Place
from mjxwalk.envs.mjcf.notes import listed

_READ = (".stl", ".obj", ".msh")  # which meshes MuJoCo opens
_FLOOR = re.compile(r"(?i)floor|ground|terrain|plane")
_HEIGHTS = mujoco.mjtGeom.mjGEOM_HFIELD
_PLANE = mujoco.mjtGeom.mjGEOM_PLANE


def take_out(spec: Any, places: Sequence[Place], notes: list[str]) -> None:
    """Takes out of a `mujoco.MjSpec` what is missing, and says so in notes.

    Raises:
      ValueError: what is missing is needed for contacts or for a body's mass.
    """
    _levelled(spec, notes)
    _without_meshes(spec, places, notes)
    _without_pairs(spec, places, notes)
    _without_keys(spec, places, notes)


def _levelled(spec: Any, notes: list[str]) -> None:
    """Makes the world's height field a plane; others are left out, and so are their files."""
    world = spec.worldbody.name
    for geom in [each for each in list(spec.geoms) if each.type == _HEIGHTS]:
        name = str(geom.name) or "without a name"
        if any(each.type == _PLANE and each.parent.name == world for each in spec.geoms):
            notes.append(f"The height field {name} is left out; there is a level floor beside it.")
            spec.delete(geom)
            continue
        notes.append(f"The height field {name} is replaced by a level plane at its height zero.")
        geom.type, geom.hfieldname, geom.size = _PLANE, "", [0.0, 0.0, 1.0]
    for field in list(spec.hfields):
        spec.delete(field)


def _without_pairs(spec: Any, places: Sequence[Place], notes: list[str]) -> None:
    """Takes out pairs of geoms of which one is missing; a missing floor is laid.

    Robots have such pairs in files that are meant to be included by one with a floor.
    """
    have = {str(geom.name) for geom in spec.geoms if geom.name}
    ends = {pair: {str(pair.geomname1), str(pair.geomname2)} for pair in spec.pairs}
    names = list(dict.fromkeys(name for each in ends.values() for name in sorted(each - have)))
    world = spec.worldbody.name
    planes = [each for each in spec.geoms if each.type == _PLANE and each.parent.name == world]
    floors = [name for name in names if _FLOOR.search(name)]
    if floors and not planes:
        spec.worldbody.add_geom(name=floors[0], type=_PLANE, size=[0.0, 0.0, 1.0])
        have.add(floors[0])
        notes.append(
            f"The file has no geom {floors[0]}, which its pairs collide with; a level plane is it."
        )
    for pair, both in ends.items():
        gone = sorted(both - have)
        if gone:
            word = f"{place_of(places, pair, 'pair')}the pair {pair.name}".rstrip()
            notes.append(f"{_capital(word)} is left out; the file has no geom {gone[0]}.")
            spec.delete(pair)


def _without_keys(spec: Any, places: Sequence[Place], notes: list[str]) -> None:
    """Takes out keyframes of another number of coordinates, such as those of a scene."""
    widths = {mujoco.mjtJoint.mjJNT_FREE: 7, mujoco.mjtJoint.mjJNT_BALL: 4}
    num = sum(widths.get(joint.type, 1) for joint in spec.joints)
    for key in list(spec.keys):
        has = len(key.qpos)
        if has not in (0, num):
            word = f"{place_of(places, key, 'key')}the keyframe {key.name}".rstrip()
            notes.append(
                f"{_capital(word)} is left out; it has {has} coordinates, and the body {num}."
            )
            spec.delete(key)


def _capital(text: str) -> str:
    return text[0].upper() + text[1:]


def _without_meshes(spec: Any, places: Sequence[Place], notes: list[str]) -> None:
    """Takes out geoms that only draw a mesh whose file is missing.

    Raises:
      ValueError: a missing mesh is needed for contacts or for a body's mass.
    """
    missing = {str(mesh.name): mesh for mesh in spec.meshes if _is_missing(spec, mesh)}
    bodies: list[str] = []
    paired = {name for pair in spec.pairs for name in (pair.geomname1, pair.geomname2)}
    for geom in list(spec.geoms):
        mesh = missing.get(str(geom.meshname))
        if mesh is None:
            continue
        body, file = str(geom.parent.name) or "without a name", str(mesh.file)
        if geom.parent.name == spec.worldbody.name:  # of the world only floors are kept
            spec.delete(geom)
            continue
        where = place_of(places, geom, "geom")
        if geom.contype or geom.conaffinity or (geom.name and geom.name in paired):
            raise ValueError(
                f"{where}the mesh {file} is missing, and body {body} collides by it; add "
                'the file, or set contype="0" conaffinity="0" and let primitive geoms collide'
            )
        if _has_mass(spec, geom):
            raise ValueError(
                f"{where}the mesh {file} is missing, and the mass of body {body} comes "
                "from it; add the file, or give the body an <inertial>"
            )
        bodies.append(body)
        spec.delete(geom)
    for site in spec.sites:
        if str(site.meshname) in missing:
            site.meshname, site.type = "", mujoco.mjtGeom.mjGEOM_SPHERE
    if bodies:
        files = [_place(spec, mesh) for mesh in missing.values()]
        notes.append(_missing_note(files, list(dict.fromkeys(bodies))))
    for mesh in missing.values():
        spec.delete(mesh)


def _missing_note(files: list[Path], bodies: list[str]) -> str:
    drawn = listed("body", bodies, "is", "are")
    if len(files) == 1:
        kind = "missing" if not files[0].is_file() else "of a kind that MuJoCo does not open"
        return f"The mesh {files[0]} is {kind}; {drawn} drawn without it."
    return (
        f"{len(files)} meshes are missing or of a kind that MuJoCo does not open, {files[0]} among "
        f"them; {drawn} drawn without them."
    )


def _is_missing(spec: Any, mesh: Any) -> bool:
    place = _place(spec, mesh)
    return bool(mesh.file) and (not place.is_file() or place.suffix.lower() not in _READ)


def _place(spec: Any, mesh: Any) -> Path:
    """Returns where MuJoCo looks for the file of a mesh."""
    folder = Path(str(spec.modelfiledir), str(mesh.compiler.meshdir))
    return Path(os.path.normpath(folder / str(mesh.file)))


def _has_mass(spec: Any, geom: Any) -> bool:
    """Returns whether a geom has a share in its body's mass."""
    compiler = geom.compiler
    always = compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    if geom.parent.explicitinertial and not always:
        return False
    if compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE:
        return False
    first, last = spec.compiler.inertiagrouprange
    heavy = geom.density if math.isnan(geom.mass) else geom.mass
    return bool(heavy) and bool(first <= int(geom.group) <= last)


def place_of(places: Sequence[Place], element: Any, tag: str) -> str:
    """Returns where an element of a `mujoco.MjSpec` is written, as a sentence begins with it."""
    line = str(element.info).partition("line ")[2].split()
    number = int(line[0]) if line else 0
    found = lines.one_of(places, line=number, tags=(tag,), name=str(element.name))
    return f"{found}: " if found else f"line {number}: " if number else ""
