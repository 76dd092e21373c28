"""The bodies that a bench can measure, by name. Imports neither JAX nor MuJoCo."""

from collections.abc import Mapping, Sequence

from mjxwalk.errors import RunError, near

BODIES: Mapping[str, str] = {
    "planar7-points": "planar-lpd: our contact points; C MuJoCo without contacts and control",
    "flame-points": "solomon-3d: our contact points; C MuJoCo without contacts and control",
    "h1-points": "Unitree H1: our contact points; MuJoCo's contacts in C MuJoCo",
    "planar7": "MuJoCo's contacts of a sphere at each contact point",
    "flame": "MuJoCo's contacts of a sphere at each contact point",
    "walker2d": "Gymnasium's file, MuJoCo's contacts",
    "humanoid": "Gymnasium's file, MuJoCo's contacts",
    "humanoid-ground": "Gymnasium's file, MuJoCo's contacts with the ground alone",
    "h1": "Unitree H1, MuJoCo's contacts",
    "walker2d-64x64": "walker2d, with two hidden layers of 64 units",
    "walker2d-256x256": "walker2d, with two hidden layers of 256 units",
}
MAIN = "planar7-points"  # the body that evolves, and whose populations grow
USUAL = (MAIN, "flame-points", "walker2d")
ON_REQUEST = ("walker2d-256x256",)  # not among "all"


def chosen(asked: Sequence[str]) -> tuple[str, ...]:
    """Returns the names that are asked for, each once, in the order of `BODIES`.

    Raises:
      RunError: a name is of no body.
    """
    for name in asked:
        if name not in (*BODIES, "all"):
            raise RunError(f"--bodies has no {name}{near(name, (*BODIES, 'all'))}")
    usual = [name for name in BODIES if name not in ON_REQUEST] if "all" in asked else []
    return tuple(name for name in BODIES if name in usual or name in asked)
