"""`--body`: the MJCF of a user's body, from a file or from a run that has one."""

import sys
from pathlib import Path
from typing import Any

from mjxwalk import robots
from mjxwalk.errors import RunError, near
from mjxwalk.runs import config, files

MOST_BYTES = files.MOST_JSON // 2  # as text in the settings, it takes somewhat more


def check(path: Path) -> None:
    """Raises unless there is such a file, run or shipped body; quick, as JAX is not imported.

    Raises:
      RunError: there is none.
    """
    if is_shipped(path):
        return
    if not path.exists():
        raise RunError(
            f"--body {path} does not exist; a body is an MJCF or URDF file, a run with a body of "
            f"its own, or the name of one that ships{near(str(path), robots.names())}"
        )
    if path.is_dir() and not (path / config.FILE).is_file():
        raise RunError(f"--body {path} is a folder, and no run; name an MJCF file, or a run")


def is_shipped(path: Path) -> bool:
    """Returns whether a name means a body that ships: files and runs of that name come first."""
    is_there = (path / config.FILE).is_file() if path.is_dir() else path.exists()
    return str(path) in robots.names() and not is_there


def read(path: Path) -> str:
    """Returns the body's XML.

    Raises:
      RunError: it cannot be read, or the run has no body of its own.
    """
    if path.is_dir():
        text = config.read_data(path)["experiment"].get("env", {}).get("body", "")
        if not text:
            raise RunError(f"--body {path} walks with a body of mjxwalk's own; leave --body out")
        return str(text)
    try:
        return files.read(path, MOST_BYTES).decode()
    except UnicodeDecodeError:
        raise RunError(f"--body {path} is no text; name an MJCF file, as XML in UTF-8") from None


def put(experiment: Any, path: Path) -> Any:
    """Returns the experiment with the body; imports JAX.

    Raises:
      RunError: the file is no body that can be simulated, or the experiment takes none.
    """
    from mjxwalk.envs import MjcfEnv
    from mjxwalk.envs.mjcf import reader
    from mjxwalk.experiments import ANY_BODY, own_body

    takes_any = isinstance(getattr(experiment, "env", None), MjcfEnv)
    file = robots.path(str(path)) if is_shipped(path) else path
    try:
        # Our own bodies' experiments take a file to the letter; others take what it comes to.
        if file.is_dir() or not takes_any:
            return own_body.with_body(experiment, read(file))
        read(file)  # refuses pipes, devices and what is no text, which MuJoCo would wait for
        found = reader.read(file)
    except ValueError as error:
        takes_few = isinstance(getattr(experiment, "env", None), own_body.BODIES)
        other = "" if not takes_few else f"; {experiment.name} takes few bodies, and {ANY_BODY} any"
        raise RunError(f"{path}: {error}{other}") from None
    try:
        changed = own_body.with_body(experiment, found.text)
    except ValueError as error:
        raise RunError(f"{path}: {found.located(str(error))}") from None
    for note in (*found.notes, *found.points):
        print(f"{path}: {note}", file=sys.stderr)
    return changed


def with_contact(experiment: Any, law: str) -> Any:
    """Returns the experiment under another contact law.

    Raises:
      RunError: its body has no other, or MJX cannot compute the body's contacts.
    """
    from mjxwalk.experiments import walk

    try:
        return walk.with_contact(experiment, law)
    except ValueError as error:
        raise RunError(str(error)) from None
