"""Reads a URDF file: its meshes by `package://`, and a free joint at its root."""

import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from mjxwalk.envs._mujoco import mujoco

_PACKAGE = "package://"


def read(path: Path, notes: list[str]) -> Any:
    """Returns the `mujoco.MjSpec` of a URDF file, free to move, as MuJoCo reads it.

    MuJoCo makes the limit of an effort a limit of the joint's actuators; motors come with those.

    Raises:
      ValueError: MuJoCo cannot read it.
    """
    try:
        robot = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise ValueError(f"it is no XML ({error}); correct it") from None
    own = robot.find("mujoco/compiler")
    given = {} if own is None else dict(own.attrib)
    meshes = Path(given.pop("meshdir", ""))
    drawn = given.pop("discardvisual", "false") != "true"
    for old in robot.findall("mujoco"):
        robot.remove(old)
    # ours: few files of CAD programs pass MuJoCo's check of inertias.
    settings = {"balanceinertia": "true", **given, "strippath": "false"}
    settings["discardvisual"] = "false" if drawn else "true"
    ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler", settings)
    for mesh in robot.iter("mesh"):
        mesh.set("filename", str(_file(mesh.get("filename", ""), path.resolve().parent, meshes)))
    spec = mujoco.MjSpec.from_string(ElementTree.tostring(robot, encoding="unicode"))
    root = spec.worldbody.first_body()
    if root is not None and not list(root.joints):
        root.add_freejoint()
        notes.append(f"The link {root.name} is given a free joint, as a URDF has none.")
    _add_friction(spec, robot)
    return spec


def _file(name: str, folder: Path, meshes: Path) -> Path:
    """Returns where the file of a mesh is: in its package, which may be any folder above."""
    if not name.startswith(_PACKAGE):
        plain = folder / name.removeprefix("file://")
        stripped = folder / meshes / Path(name).name
        return stripped if stripped.is_file() and not plain.is_file() else plain
    package, _, inside = name.removeprefix(_PACKAGE).partition("/")
    above = [folder, *folder.parents]
    tries = [each / package / inside for each in above]
    tries += [each / inside for each in above]
    tries += [folder / meshes / Path(inside).name]
    return next((each for each in tries if each.is_file()), folder / inside)


def _add_friction(spec: Any, robot: ElementTree.Element) -> None:
    """Gives joints the dry friction that MuJoCo reads over."""
    friction = {
        joint.get("name"): float(each.get("friction", "0"))
        for joint in robot.iter("joint")
        for each in joint.findall("dynamics")
    }
    for joint in spec.joints:
        loss = friction.get(str(joint.name), 0.0)
        if math.isfinite(loss) and loss > 0.0:
            joint.frictionloss = loss
