"""Reads a user's MJCF or URDF file once into one text that refers to no other file.

All else is derived from that text alone: it is in every run, and read back through the table in
`body_xml.py` only.
"""

from pathlib import Path
from typing import Any, NamedTuple

from mjxwalk.envs import body_xml, mjcf_kept, mjcf_opening, mjcf_writer


class BodyFile(NamedTuple):
    """A body that a user brings.

    Attributes:
      text: MJCF that refers to no other file, and that `body_xml.checked` lets through.
      notes: what of the file is not taken or is replaced, as sentences for users.
    """

    text: str
    notes: tuple[str, ...]


def read(path: Path) -> BodyFile:
    """Returns the body of an MJCF or URDF file.

    Raises:
      ValueError: the file is missing, or no body; the message says what, and what to do.
    """
    found = mjcf_opening.opened(path)
    notes = found.notes
    root = _robot(found.model, notes)
    kept = mjcf_kept.kept(found.model, root, found.statistic)
    text = mjcf_writer.text(kept, {}, {}, {})
    body_xml.checked(text)
    return BodyFile(text, tuple(notes))


def _robot(model: Any, notes: list[str]) -> int:
    """Returns the body whose tree has the most joints.

    Raises:
      ValueError: there are no bodies, none has a joint, or two trees have as many.
    """
    roots = [body for body in range(1, model.nbody) if not model.body_parentid[body]]
    if not roots:
        raise ValueError("it has no bodies; a robot is a <body> with joints in <worldbody>")
    joints = {
        root: sum(
            int(model.body_jntnum[body])
            for body in range(1, model.nbody)
            if mjcf_kept.top(model, body) == root
        )
        for root in roots
    }
    most = max(joints.values())
    best = [root for root in roots if joints[root] == most]
    names = [str(model.body(root).name) or f"number {root}" for root in roots]
    if most == 0:
        raise ValueError("it has no joints; a robot needs some to walk")
    if len(best) > 1:
        one, two = (names[roots.index(each)] for each in best[:2])
        raise ValueError(
            f"the bodies {one} and {two} have as many joints each, {most}; leave one robot in it"
        )
    for root, name in zip(roots, names, strict=True):
        if root == best[0]:
            continue
        if model.body_mocapid[root] >= 0:
            notes.append(f"Body {name} is moved from outside (mocap); it is left out.")
        elif joints[root]:
            notes.append(f"Body {name} moves beside the robot; it is left out.")
        else:
            notes.append(f"Body {name} stands beside the robot; it is left out.")
    return best[0]
