"""`--body`: the MJCF of a user's body, from a file or from a run that has one."""

from pathlib import Path
from typing import Any

from mjxwalk.errors import RunError
from mjxwalk.runs import config, files

MOST_BYTES = files.MOST_JSON // 2  # as text in the settings, it takes somewhat more


def check(path: Path) -> None:
    """Returns if there is such a file or run, whatever it holds; quick, as JAX is not imported.

    Raises:
      RunError: there is none.
    """
    if not path.exists():
        raise RunError(
            f"--body {path} does not exist; name an MJCF file (docs/body.md), or a run with a body "
            "of its own"
        )
    if path.is_dir() and not (path / config.FILE).is_file():
        raise RunError(f"--body {path} is a folder, and no run; name an MJCF file, or a run")


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
    from mjxwalk.experiments import own_body

    text = read(path)
    try:
        return own_body.with_body(experiment, text)
    except ValueError as error:
        raise RunError(f"{path}: {error}") from None
