"""Which body a task has: one of ours, one that ships as a file, a user's file, or a run's."""

from collections.abc import Mapping
from pathlib import Path

from mjxwalk import robots
from mjxwalk.envs import BODIES, LeggedEnv, MjcfEnv
from mjxwalk.errors import near
from mjxwalk.experiments import run_config

OF_FILES = "Body"  # in the name of the task that is told its body's file


def tasks() -> Mapping[str, str | None]:
    """Returns the bodies by the middle of their tasks' names; None where the caller names one.

    A body that ships as a file, and that has laws of its own besides, is there once.
    """
    shipped = {_title(name): name for name in robots.names()}
    return {**shipped, **{name: name for name in BODIES}, OF_FILES: None}


def make(body: str | Path | None) -> LeggedEnv:
    """Returns the body with its usual settings, or those of a run.

    Raises:
      ValueError: there is no such body, or its file is refused.
      RunError: a run's settings cannot be read.
    """
    if body is None:
        raise ValueError('name a body, such as body="robot.xml", an MJCF or URDF file')
    if str(body) in BODIES:
        return BODIES[str(body)]()
    path = Path(body)
    if path.is_dir():
        return _of_run(path)
    is_shipped = not path.exists()
    if is_shipped and str(body) not in robots.names():
        raise ValueError(
            f"body must be a file, a run's folder or a name that is known, got {str(body)!r}"
            f"{near(str(body), (*BODIES, *robots.names()))}"
        )
    return _of_file(robots.path(str(body)) if is_shipped else path, tells=not is_shipped)


def _of_run(path: Path) -> LeggedEnv:
    env = getattr(run_config.read(path).experiment, "env", None)
    if not isinstance(env, LeggedEnv):
        raise ValueError(f"body must be a run of a walker, and {path} has none")
    return env


def _of_file(path: Path, *, tells: bool) -> LeggedEnv:
    """Returns the body of a file; what the file says and is left out or replaced is told."""
    import gymnasium

    from mjxwalk.envs.mjcf import reader

    try:
        found = reader.read(path)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    try:
        env = MjcfEnv.of(found.text)
    except ValueError as error:
        raise ValueError(f"{path}: {found.located(str(error))}") from None
    for note in (*found.notes, *found.points) if tells else ():
        gymnasium.logger.warn(f"{path}: {note}")
    return env


def _title(name: str) -> str:
    """Returns a name as classes have it, such as BerkeleyHumanoid."""
    return "".join(word[:1].upper() + word[1:] for word in name.split("_"))
