"""The text of a user's own task, as the file `task.py` in the folder of its run."""

import hashlib
from pathlib import Path
from typing import NamedTuple

from mjxwalk.errors import RunError
from mjxwalk.runs import config, files
from mjxwalk.runs.config import Code

FILE = "task.py"
MOST_BYTES = 1 << 20  # ours: of a file that a person writes


class TaskText(NamedTuple):
    """The text of a file with Python in it, read once; what is executed is this text.

    Attributes:
      shown: its path, for complaints.
      content: of the file.
    """

    shown: str
    content: bytes

    @property
    def sha256(self) -> str:
        """What tells the text from any other."""
        return hashlib.sha256(self.content).hexdigest()


def code_of(folder: Path) -> Code | None:
    """Returns which code the run in a folder has, None of one without.

    Raises:
      RunError: the folder holds no run, or its settings are not what was written.
    """
    file, content = config.read(folder)
    config.check(folder, file, content)
    return file.own_code


def write(folder: Path, content: bytes) -> None:
    """Writes the text into the folder of a run.

    Raises:
      RunError: it cannot be written.
    """
    files.replace(folder, FILE, content)


def read(folder: Path, code: Code) -> TaskText:
    """Returns the text of a run, read once.

    Raises:
      RunError: it is missing, or not the text that the run was made with.
    """
    path = folder / FILE
    content = files.read_inside(folder, FILE, MOST_BYTES)
    if content is None:
        raise RunError(f"{folder} lacks {FILE}, the text of its task {code.file}")
    text = TaskText(str(path), content)
    if text.sha256 != code.sha256:
        raise RunError(
            f"{path} was changed since the run was made: its sha256 is {text.sha256[:16]}... and "
            f"the run was made with {code.sha256[:16]}...; put back the text as it was, or evolve "
            "the changed file anew"
        )
    return text
