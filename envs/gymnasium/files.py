"""The bodies of Gymnasium's tasks, from the package where it is installed."""

import functools
import importlib.util
from pathlib import Path

from mjxwalk.envs.mjcf import reader

FOLDER = "envs/mujoco/assets"  # of the package
INSTALL = 'install it, as by pip install "mjxwalk[gym]"'


@functools.cache
def text(name: str) -> str:
    """Returns the MJCF of one of Gymnasium's files; "" where Gymnasium is not installed.

    Its masses, joints, geoms, motors and options are those of the file; what only pictures show is
    left out.

    Args:
      name: of the file.

    Raises:
      ValueError: the installed Gymnasium has no such file.
    """
    # Importing Gymnasium's own MuJoCo tasks would ask for packages that draw pictures.
    found = importlib.util.find_spec("gymnasium")
    if found is None or found.origin is None:
        return ""
    path = Path(found.origin).parent / FOLDER / name
    if not path.exists():
        raise ValueError(
            f"the installed gymnasium has no {name}; {INSTALL}, which brings one that has it"
        )
    return reader.read(path).text
