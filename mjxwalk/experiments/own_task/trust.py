"""Whose code may be executed: texts that this user ran on this machine, known by their digest.

The digests are in a file that only this user can write. A run's folder comes from anybody, so that
nothing in it can say that it is to be trusted.
"""

import os
from pathlib import Path

from mjxwalk import data_folder
from mjxwalk.errors import RunError
from mjxwalk.runs import task_file
from mjxwalk.runs.config import Code

FILE = "trusted-tasks"
# Digests that were trusted in this process, also where no file can be written.
_here: set[str] = set()


def trust(sha256: str, file: str) -> None:
    """Trusts a text from now on, in this process and, if a file can be written, in later ones.

    Args:
      sha256: of the text.
      file: what it was called, for whoever reads the file.
    """
    if sha256 in _here:
        return
    _here.add(sha256)
    if sha256 not in data_folder.lines(FILE):
        plain = "".join(letter if letter.isprintable() else "?" for letter in Path(file).name)
        data_folder.append(FILE, f"{sha256} {plain.encode(errors='replace').decode()}")


def is_trusted(sha256: str) -> bool:
    """Returns whether this user ran a text, or said to trust it."""
    return sha256 in _here or sha256 in data_folder.lines(FILE)


def check(folder: Path, code: Code) -> None:
    """Raises RunError unless the code of a run may be executed."""
    if not is_trusted(code.sha256):
        raise RunError(
            f"{folder} runs code that was not written on this machine: {folder / task_file.FILE} "
            f"(made as {code.file}, sha256 {code.sha256}); read it, and add --trust if you want "
            "it executed"
        )


def check_run(folder: Path, *, is_given: bool = False) -> None:
    """Raises RunError unless the code of a run, if it has any, may be executed.

    It executes nothing and imports no JAX. What is trusted is the digest: another text that is put
    in the file's place later is refused where it is read.

    Args:
      folder: of the run; one that holds none has no code.
      is_given: whether the user said to trust it.
    """
    if not os.path.isfile(folder / "config.json"):
        return
    code = task_file.code_of(folder)
    if code is None:
        return
    if is_given:
        task_file.read(folder, code)
        trust(code.sha256, code.file)
    check(folder, code)
