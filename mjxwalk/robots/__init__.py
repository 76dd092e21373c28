"""Bodies that ship with mjxwalk as MJCF files, named where a command takes `--body`.

Each file holds one body, refers to no other file, and says at its top what it derives from. Its
licence lies beside it. Imports neither JAX nor MuJoCo.
"""

import dataclasses
import importlib.util
from collections.abc import Mapping
from pathlib import Path

from mjxwalk.errors import RunError, near

FOLDER = Path(__file__).parent
OWN_LICENCE = "Apache-2.0"  # of mjxwalk


@dataclasses.dataclass(frozen=True, kw_only=True)
class ShippedBody:
    """What is known of a body without opening its file.

    Attributes:
      summary: what it is, in a line.
      source: what its file derives from.
      licence: under which it may be used, as SPDX has it; the text is in `licence_path`.
    """

    summary: str
    source: str
    licence: str = OWN_LICENCE


_PLAYGROUND = "of MuJoCo Menagerie and MuJoCo Playground"
BODIES: Mapping[str, ShippedBody] = {
    "h1": ShippedBody(
        summary="Unitree H1, a humanoid robot of 1.75 m and 51 kg, 19 position motors",
        source=f"unitree_h1 {_PLAYGROUND}",
        licence="BSD-3-Clause AND Apache-2.0",
    ),
    "g1": ShippedBody(
        summary="Unitree G1, a humanoid robot of 1.32 m and 33 kg, 29 position motors",
        source=f"unitree_g1 {_PLAYGROUND}",
        licence="BSD-3-Clause AND Apache-2.0",
    ),
    "t1": ShippedBody(
        summary="Booster T1, a humanoid robot of 1.18 m and 32 kg, 23 position motors",
        source=f"booster_t1 {_PLAYGROUND}",
    ),
    "apollo": ShippedBody(
        summary="Apptronik Apollo, a humanoid robot of 1.76 m and 81 kg, 32 position motors",
        source=f"apptronik_apollo {_PLAYGROUND}",
    ),
    "op3": ShippedBody(
        summary="Robotis OP3, a small humanoid robot of 0.5 m and 3.1 kg, 20 position motors",
        source=f"robotis_op3 {_PLAYGROUND}",
    ),
    "berkeley_humanoid": ShippedBody(
        summary="Berkeley Humanoid, a robot without arms, 0.83 m and 16 kg, 12 position motors",
        source=f"berkeley_humanoid {_PLAYGROUND}",
        licence="BSD-3-Clause AND Apache-2.0",
    ),
    "humanoid": ShippedBody(
        summary="Gymnasium's Humanoid with toes, 1.56 m and 42 kg, 17 torque motors",
        source="measures of humanoid.xml of Gymnasium",
        licence="MIT",
    ),
    "walker2d": ShippedBody(
        summary="Gymnasium's Walker2d in the plane, 1.5 m and 24 kg, 6 torque motors",
        source="measures of walker2d_v5.xml of Gymnasium",
        licence="MIT",
    ),
    "planar7": ShippedBody(
        summary="a human's trunk and legs in the plane, 1.75 m and 70 kg, 6 torque motors",
        source="Solomon, Locascio and Hartmann (2013), Table 1",
    ),
    "flame": ShippedBody(
        summary="the robot Flame's trunk and legs, 1.1 m and 15 kg, given 10 torque motors",
        source="Solomon, Locascio and Hartmann (2013), section 2.6",
    ),
}
_OF_OWN = ("planar7", "flame")  # whose files lie beside the code that simulates them


def names() -> list[str]:
    """Returns the names of all bodies, those of other projects first."""
    return list(BODIES)


def path(name: str) -> Path:
    """Returns where a body's MJCF is.

    Raises:
      RunError: there is none of the name.
    """
    _check(name)
    if name not in _OF_OWN:
        return FOLDER / f"{name}.xml"
    found = importlib.util.find_spec("mjxwalk.envs")  # does not import it, nor JAX with it
    assert found is not None and found.origin is not None
    return Path(found.origin).parent / "bodies" / f"{name}.xml"


def licence_path(name: str) -> Path | None:
    """Returns where the text of a body's licence is; None if it is that of mjxwalk.

    Raises:
      RunError: there is no body of the name.
    """
    _check(name)
    return None if name in _OF_OWN else FOLDER / f"{name}.LICENSE"


def text(name: str) -> str:
    """Returns a body's MJCF.

    Raises:
      RunError: there is none of the name.
    """
    return path(name).read_text(encoding="utf-8")


def _check(name: str) -> None:
    if name not in BODIES:
        raise RunError(f"there is no body {name}{near(name, BODIES)}")
