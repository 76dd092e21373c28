"""Experiments and studies by name. Naming them is quick: JAX is imported by `get` alone.

A study is a chain of experiments, its phases; a phase is an experiment of its own, STUDY/PHASE.
"""

import dataclasses
import importlib
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from mjxwalk.errors import near

if TYPE_CHECKING:
    from mjxwalk.experiments.experiment import Experiment
    from mjxwalk.experiments.study import Study

DEFAULT = "planar-lpd"
ANY_BODY = "walk"  # what a body evolves in where no experiment is named
# What may decide in place of an experiment's own controller, and what each is, in a line.
CONTROLLERS = {
    "linear": "weighted sums of senses and a clock",
    "mlp": "a perceptron of two hidden layers",
    "recurrent": "a recurrent network, gated or Elman's",
    "ctrnn": "a pattern generator of continuous-time neurons, with senses or without",
    "harmonics": "harmonics of a clock alone",
}
# What names older runs have, and what these are now.
RENAMED = {f"walk-{name}": f"walk+{name}" for name in ("mlp", "recurrent", "ctrnn", "harmonics")}


class Entry(NamedTuple):
    """Where an experiment or a study is, from this package, and what it is in a line.

    Attributes:
      module: that has it.
      attribute: its name there; "" where the module's `of_task` makes it of the task's name.
      summary: what it is.
      phases: of a study, what each is.
    """

    module: str
    attribute: str
    summary: str
    phases: Mapping[str, str] = {}


_WALK = "local links, from zero, on slightly rough ground"
_ROUGH = "local links, around the winner of walk, on ever rougher ground"
_STEADY = "local links, around the mean of rough, for fewer falls"
_LPD, _FIL = "local links, around the mean of steady", "all links, around the winner of lpd"
_SIL = "goes on from fil and prunes its links"

_ASSISTED = "pattern generator, its trunk righted, until one walks 20 m"
_UNASSISTED = "that population goes on without assistance"
_HOLDING = "and from other starts, with loads and on slopes"

_TASKS = {  # Gymnasium's, to the letter
    "Walker2d-v5": "two legs in the plane",
    "Hopper-v5": "one leg in the plane",
    "HalfCheetah-v5": "two legs in the plane, one behind the other",
    "Ant-v5": "four legs in space",
    "Humanoid-v5": "a man in space",
}
EXPERIMENTS = {
    ANY_BODY: Entry(
        ".walk", "WALK", "any body (--body FILE or NAME), linear feedback to joint targets"
    ),
    "planar-lpd": Entry(".solomon", "PLANAR_LPD", "planar walker, local links, slightly rough"),
    "planar-fil": Entry(".solomon", "PLANAR_FIL", "planar walker, all links, slightly rough"),
    "solomon-3d": Entry(".solomon_3d", "SOLOMON_3D", "spatial walker, slightly rough ground"),
    "reil-unassisted": Entry(
        ".reil",
        "REIL_UNASSISTED",
        "biped with powered hips, pattern generator, no assistance",
    ),
    "rayleigh": Entry(".rayleigh", "RAYLEIGH", "four Rayleigh oscillators fitted to human walking"),
    "rayleigh-harmonic": Entry(
        ".rayleigh", "RAYLEIGH_HARMONIC", "an oscillator for each harmonic of each leg, likewise"
    ),
    "rayleigh-walk": Entry(
        ".rayleigh_walk", "RAYLEIGH_WALK", "planar walker driven by the fitted oscillators"
    ),
    **{
        f"gymnasium/{task}": Entry(
            ".gymnasium_tasks", "", f"Gymnasium's {task}, {what}: linear feedback by random search"
        )
        for task, what in _TASKS.items()
    },
}
STUDIES = {
    "reil": Entry(
        ".reil",
        "REIL",
        "Reil & Massey (2001): hips driven by a pattern generator, with assistance and without",
        {"assisted": _ASSISTED, "unassisted": _UNASSISTED, "steady": _HOLDING},
    ),
    "reil-feedback": Entry(
        ".reil",
        "REIL_FEEDBACK",
        "the same, and then with senses in the pattern generator",
        {
            "assisted": _ASSISTED,
            "unassisted": _UNASSISTED,
            "feedback": "the winner's network with trunk pitch and foot contact, around it",
        },
    ),
    "solomon-2d": Entry(
        ".solomon",
        "SOLOMON_2D",
        "Solomon et al. (2013) in the plane: local links, all links, pruned links",
        {
            "walk": _WALK,
            "rough": _ROUGH,
            "steady": _STEADY,
            "lpd": _LPD,
            "fil": _FIL,
            "sil": _SIL,
        },
    ),
    "solomon-2d-rsil": Entry(
        ".solomon",
        "SOLOMON_2D_RSIL",
        "the same with the links alone that pruning leaves",
        {
            "walk": _WALK,
            "rough": _ROUGH,
            "steady": _STEADY,
            "lpd": _LPD,
            "rsil": "the links that pruning leaves, around the winner of lpd",
        },
    ),
    "solomon-2d-literal": Entry(
        ".solomon",
        "SOLOMON_2D_LITERAL",
        "the paper's protocol to the letter: its roughness from the first generation",
        {"lpd": "local links, from zero", "fil": _FIL, "sil": _SIL},
    ),
    "solomon-3d-rough": Entry(
        ".solomon_3d",
        "SOLOMON_3D_ROUGH",
        "Solomon et al. (2013) in space: from slightly rough ground to ten times as rough",
        {
            "slight": "spatial walker, from zero, on slightly rough ground",
            "rough": "around the winner of slight, on ever rougher ground",
        },
    ),
    "flame-robust": Entry(
        ".solomon_3d",
        "FLAME_ROBUST",
        "a spatial walker that stays up where the paper's fell",
        {
            "slight": "spatial walker, from zero, on slightly rough ground",
            "rough": "around the winner of slight, on ever rougher ground",
            "steady": "around the mean of rough, for fewer falls",
            "robust": "around the mean of steady, finer",
        },
    ),
}


# Experiments of others, by name; of this process alone.
_REGISTERED: dict[str, Any] = {}


def register(experiment: Any) -> None:
    """Makes an experiment known by its name, in this process.

    Its runs are then read back with its classes, and every command works on them. A run's folder
    only names its experiment and can register nothing.

    Args:
      experiment: an `Experiment`, or another frozen dataclass with all that the evolution needs.

    Raises:
      ValueError: it is no dataclass, its name is not one for a folder, or another experiment or a
        study has that name.
    """
    name = str(getattr(experiment, "name", ""))
    if not dataclasses.is_dataclass(experiment) or isinstance(experiment, type):
        raise ValueError(f"an experiment must be a frozen dataclass, got {experiment!r}")
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}", name):
        raise ValueError(f"name must be letters, digits, dots and hyphens, got {name!r}")
    if name in STUDIES or (name in names() and name not in _REGISTERED):
        raise ValueError(f"there is an experiment or a study {name!r} already; choose another name")
    _REGISTERED[name] = experiment


def names() -> dict[str, str]:
    """Returns each experiment's name and what it is, in a line; phases of studies come last."""
    found = {name: entry.summary for name, entry in EXPERIMENTS.items()}
    found |= {name: "registered by this program" for name in _REGISTERED}
    for study, entry in STUDIES.items():
        found |= {f"{study}/{phase}": summary for phase, summary in entry.phases.items()}
    return found


def studies() -> dict[str, str]:
    """Returns each study's name and what it is, in a line."""
    return {name: entry.summary for name, entry in STUDIES.items()}


def phases(study: str) -> list[str]:
    """Returns the names of a study's phases, first to last."""
    return list(STUDIES[study].phases)


def get(name: str, body: str = "") -> "Experiment":
    """Returns the experiment of that name; EXPERIMENT+CONTROLLER is one with another controller.

    Args:
      name: of the experiment.
      body: MJCF of a task whose file is another package's, for where that is not installed.

    Raises:
      ValueError: there is none, and the message names the nearest; or it takes no other controller.
    """
    if name in _REGISTERED:
        return _REGISTERED[name]
    name = RENAMED.get(name, name)
    name, plus, controller = name.partition("+")
    if plus:
        from mjxwalk.experiments import other_controllers

        if controller not in CONTROLLERS:
            raise ValueError(f"unknown controller {controller!r}{near(controller, CONTROLLERS)}")
        return other_controllers.with_controller(get(name, body), controller)
    if name in EXPERIMENTS:
        return _load(EXPERIMENTS[name], name.partition("/")[2], body)
    if name in names():
        study, _, phase = name.partition("/")
        return get_study(study).phase(phase)
    raise ValueError(f"unknown experiment {name!r}{near(name, names())}")


def get_study(name: str) -> "Study":
    """Returns the study of that name.

    Raises:
      ValueError: there is none; the message names the nearest.
    """
    if name not in STUDIES:
        raise ValueError(f"unknown study {name!r}{near(name, STUDIES)}")
    return _load(STUDIES[name])


def _load(entry: Entry, task: str = "", body: str = "") -> Any:
    module = importlib.import_module(entry.module, "mjxwalk.experiments")
    if not entry.attribute:
        return module.of_task(task, body)
    return getattr(module, entry.attribute)
