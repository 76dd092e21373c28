"""Which file and which experiment of it a user means; imports no JAX."""

import ast
import importlib.util
import re
from pathlib import Path
from typing import NamedTuple

from mjxwalk.errors import RunError
from mjxwalk.runs import files, task_file
from mjxwalk.runs.task_file import TaskText

ENDING = ".py"
NAME = re.compile(r"[^\W\d]\w*")


class Named(NamedTuple):
    """A task as it was asked for.

    Attributes:
      file: as it was typed: a path, or the name of a module.
      name: of the experiment in it; "" for the only one.
    """

    file: str
    name: str

    @property
    def title(self) -> str:
        """A name for a folder: the file's without its ending, and the experiment's."""
        stem = Path(self.file).name.removesuffix(ENDING)
        plain = re.sub(r"[^A-Za-z0-9._-]+", "-", stem).strip("-.") or "task"
        return f"{plain}-{self.name}" if self.name else plain


def is_task(text: str) -> bool:
    """Returns whether what was asked for is a file or a module, and no experiment of ours."""
    file, colon, name = text.rpartition(":")
    return text.endswith(ENDING) or bool(colon and file and (NAME.fullmatch(name) or not name))


def find(text: str) -> tuple[Named, Path]:
    """Returns what was asked for, and where its file is.

    Args:
      text: FILE.py, FILE.py:NAME, or MODULE:NAME of a file in the current folder or of a module
        that Python finds.

    Raises:
      RunError: there is no such file.
    """
    named = _split(text)
    path = Path(named.file)
    if named.file.endswith(ENDING):
        if not path.exists():
            raise RunError(
                f"{named.file} does not exist; `mjxwalk new task {named.file}` writes an example"
            )
        return named, path
    beside = Path(f"{named.file}{ENDING}")
    if beside.exists():
        return named, beside
    return named, _module(named.file)


def _split(text: str) -> Named:
    if text.endswith(ENDING):
        return Named(text, "")
    file, _, name = text.rpartition(":")
    if not NAME.fullmatch(name):
        raise RunError(f"{text} needs a name behind its colon, such as {file}:TASK")
    return Named(file, name)


def _module(name: str) -> Path:
    try:
        spec = importlib.util.find_spec(name)
    except (ImportError, ValueError):
        spec = None
    if spec is None or not spec.origin or not spec.origin.endswith(ENDING):
        raise RunError(
            f"there is no file {name}{ENDING} in this folder, and no module {name} that Python "
            "finds; name a file, such as my_task.py"
        )
    return Path(spec.origin)


def read(path: Path) -> TaskText:
    """Returns a file's text, read once.

    Raises:
      RunError: it cannot be read.
    """
    return TaskText(str(path), files.read(path, task_file.MOST_BYTES))


def check_syntax(text: TaskText) -> ast.Module:
    """Returns the syntax tree of a file.

    Raises:
      RunError: the file is no Python; names its line.
    """
    try:
        return ast.parse(text.content, text.shown)
    except SyntaxError as error:
        line = f":{error.lineno}" if error.lineno else ""
        raise RunError(f"{text.shown}{line}: the syntax is wrong: {error.msg}") from None
    except (ValueError, RecursionError, MemoryError) as error:
        raise RunError(f"{text.shown} is no Python file: {error}") from None
