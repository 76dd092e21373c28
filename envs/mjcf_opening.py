"""Opens a user's MJCF or URDF file as MuJoCo does, without what only decorates."""

import math
import os
from pathlib import Path
from typing import Any, NamedTuple

from mjxwalk.envs._mujoco import compiled, mujoco, refusing

_DECORATION = ("textures", "skins", "sensors", "cameras", "lights", "tuples", "texts", "numerics")


class Opened(NamedTuple):
    """A file that MuJoCo has read.

    Attributes:
      model: the `mujoco.MjModel`.
      statistic: what the file gives of the model's statistic.
      notes: what of the file is not taken, as sentences.
    """

    model: Any
    statistic: dict[str, Any]
    notes: list[str]


def opened(path: Path) -> Opened:
    """Returns the compiled model of a file.

    Raises:
      ValueError: it is no MJCF or URDF that can be a body; the message says why.
    """
    if not path.exists():
        raise ValueError("it does not exist; name an MJCF or URDF file")
    if path.is_dir():
        raise ValueError("it is a folder; name an MJCF or URDF file")
    with refusing("MuJoCo cannot read it"):
        spec = mujoco.MjSpec.from_file(str(path.resolve()))
    notes: list[str] = []
    _undecorate(spec)
    _without_missing(spec, notes)
    statistic = {
        name: getattr(spec.stat, name)
        for name in ("meaninertia", "meanmass", "meansize", "extent", "center")
    }
    return Opened(
        compiled(spec),
        {name: value for name, value in statistic.items() if _is_given(value)},
        notes,
    )


def _is_given(value: Any) -> bool:
    return not any(math.isnan(each) for each in (value if hasattr(value, "__len__") else [value]))


def _undecorate(spec: Any) -> None:
    """Takes out what only decorates: it may need files, and is not written."""
    for kind in _DECORATION:
        for each in list(getattr(spec, kind)):
            spec.delete(each)
    for material in spec.materials:
        material.textures = ["" for _ in material.textures]


def _without_missing(spec: Any, notes: list[str]) -> None:
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
        if geom.contype or geom.conaffinity or (geom.name and geom.name in paired):
            raise ValueError(
                f"{_where(geom)}the mesh {file} is missing, and body {body} collides by it; add "
                'the file, or set contype="0" conaffinity="0" and let primitive geoms collide'
            )
        if _has_mass(spec, geom):
            raise ValueError(
                f"{_where(geom)}the mesh {file} is missing, and the mass of body {body} comes "
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
    if len(files) == 1:
        return f"The mesh {files[0]} is missing; {_bodies(bodies)} drawn without it."
    return (
        f"{len(files)} meshes are missing, {files[0]} among them; {_bodies(bodies)} drawn without "
        "them."
    )


def _bodies(names: list[str]) -> str:
    if len(names) == 1:
        return f"body {names[0]} is"
    shown = ", ".join(names[:3])
    return (
        f"bodies {shown} and {len(names) - 3} more are"
        if len(names) > 3
        else (f"bodies {', '.join(names[:-1])} and {names[-1]} are")
    )


def _is_missing(spec: Any, mesh: Any) -> bool:
    return bool(mesh.file) and not _place(spec, mesh).is_file()


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


def _where(element: Any) -> str:
    """Returns the line of an element, as far as MuJoCo knows it."""
    line = str(element.info).partition("line ")[2].split()
    return f"line {line[0]}: " if line and line[0] != "0" else ""
