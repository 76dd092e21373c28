"""Tells of files which walk, and why the others are refused: the table in docs/any-body.md."""

import dataclasses
import os
import sys
from pathlib import Path
from typing import Annotated, Any

import tyro

from mjxwalk import cli

Files = tyro.conf.Positional[Annotated[tuple[Path, ...], tyro.conf.arg(metavar="FILE ...")]]
# So that a trial goes on whatever the body does.
LENIENT = {
    **dict.fromkeys(("max_pitch", "max_roll", "max_yaw", "max_flight_time", "max_lag"), 100.0),
    "min_height": 0.001,
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class BodyFiles:
    """Tell of MJCF and URDF files which walk, and why the others are refused, as Markdown.

    Attributes:
      files: to read.
      under: folder that the names are given from.
      seconds: how long each body is simulated with its motors at rest, s; 0 for not at all.
      notes: whether what is left out or replaced is told too.
    """

    files: Files
    under: Path | None = None
    seconds: float = 0.2
    notes: bool = False

    def run(self) -> int:
        """Prints the table and returns the exit code."""
        print("| file | what comes of it |\n| --- | --- |")
        for path in self.files:
            name = _from(self.under, path) if self.under else path
            told, notes = tell(path, self.seconds)
            lines = [told, *(notes if self.notes else ())]
            shown = "<br>".join(line.replace("<", "&lt;") for line in lines)
            folder = str(path.resolve().parent) + os.sep
            print(f"| `{name.as_posix()}` | {shown.replace(folder, '')} |", flush=True)
        return 0


def _from(folder: Path, path: Path) -> Path:
    folder, path = folder.absolute(), path.absolute()
    return path.relative_to(folder) if path.is_relative_to(folder) else path


def tell(path: Path, seconds: float) -> tuple[str, tuple[str, ...]]:
    """Returns what comes of a file, and the notes about it.

    Args:
      path: of the file.
      seconds: how long the body is simulated, its motors at rest.
    """
    from mjxwalk.envs import MjcfEnv
    from mjxwalk.envs.mjcf import reader

    try:
        body = reader.read(path)
    except ValueError as error:
        return f"refused: {error}", ()
    notes = (*body.notes, *body.points)
    try:
        env = MjcfEnv.of(body.text, **LENIENT)
    except ValueError as error:
        return f"refused: {body.located(str(error))}", notes
    anatomy = env.anatomy
    plane = " in the plane" if anatomy.root.is_planar else ""
    moves = f"{len(anatomy.legs)} legs, {len(anatomy.motors)} motors{plane}"
    if seconds and not stays_finite(env, seconds):
        return f"diverges: {moves}", notes
    return f"walks: {moves}", notes


def stays_finite(env: Any, seconds: float) -> bool:
    """Returns whether a body at rest is still sound after a time, s."""
    import jax
    import jax.numpy as jnp

    given = env.level_trials().given(0)
    nothing = jnp.zeros(len(env.anatomy.motors))

    @jax.jit
    def rolled() -> Any:
        steps = round(seconds / env.timestep)
        start = env.reset(given)
        return jax.lax.fori_loop(0, steps, lambda _, state: env.step(state, nothing, given), start)

    end = rolled()
    return not bool(end.trial.diverged) and bool(jnp.isfinite(end.qpos).all())


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # short trials; leave the GPU to its owner
    sys.exit(cli.run("body_files.py", BodyFiles))
