"""Reads a user's MJCF or URDF file once into one text that refers to no other file.

All else is derived from that text alone: it is in every run, and read back through the table in
`body_xml.py` only.
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from mjxwalk.envs import body_xml
from mjxwalk.envs.derived import source
from mjxwalk.envs.mjcf import added_motors, lines, meshes, messages, opening, robot, writer
from mjxwalk.envs.mjcf import kept as mjcf_kept
from mjxwalk.envs.mjcf import notes as mjcf_notes


class BodyFile(NamedTuple):
    """A body that a user brings.

    Attributes:
      text: MJCF that refers to no other file, and that `body_xml.checked` lets through.
      notes: what of the file is not taken or is replaced, as sentences for users.
      points: what contact law `points` leaves out or replaces besides, as sentences.
      places: the elements of the file.
    """

    text: str
    notes: tuple[str, ...]
    points: tuple[str, ...]
    places: tuple[lines.Place, ...]

    def located(self, sentence: str) -> str:
        """Returns a sentence about the text that begins with the line of the file it is about."""
        return lines.located(self.places, sentence)


def read(path: Path) -> BodyFile:
    """Returns the body of an MJCF or URDF file.

    Raises:
      ValueError: the file is missing, or no body; the message says what, and what to do.
    """
    try:
        return _read(path)
    except UnicodeDecodeError:  # MuJoCo reads any bytes, and fails where it gives a name
        raise ValueError(
            "it has names that are not in UTF-8; save it, and what it includes, as UTF-8"
        ) from None


def _read(path: Path) -> BodyFile:
    found = opening.opened(path)
    notes = found.notes
    root = robot.find(found.model, notes)
    kept = mjcf_kept.kept(found.model, root, found.statistic)
    try:
        robot.check(kept)
    except ValueError as error:
        raise ValueError(lines.located(found.places, str(error))) from None
    robot.note_scenery(kept, notes)
    shapes, hulls = meshes.shapes(kept)
    text = writer.text(kept, shapes, hulls, {})
    if not kept.actuators:
        motors, note = added_motors.of_body(kept, text)
        notes += [note] if note else []
        text = writer.text(kept, shapes, hulls, {"actuator": motors})
    _check(text, found.places)
    points = mjcf_notes.of_points(kept, found.places)
    return BodyFile(text, tuple(notes), points, tuple(found.places))


def _check(text: str, places: Sequence[lines.Place]) -> None:
    """Raises ValueError unless the text may be a body's, and MuJoCo can compile it."""
    try:
        body_xml.checked(text)
    except ValueError as error:  # whose line is that of the text
        raise ValueError(re.sub(r"^line \d+: ", "", str(error))) from None
    try:
        source.model(text)
    except ValueError as error:
        raise ValueError(messages.sentence(str(error), places)) from None
