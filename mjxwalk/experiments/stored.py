"""Settings of experiments as plain data, as runs store them, of this version and of older ones."""

import dataclasses
from typing import Any

from mjxwalk import settings
from mjxwalk.errors import RunError
from mjxwalk.experiments import own_task, registry
from mjxwalk.runs import Run, config

# What settings were called when older runs were written, and what they are called now.
RENAMED = {"arena": "test_settings"}

BY_DEFAULT = object()  # what a group of settings is as its class has it

# Settings that experiments did not have when older runs were written, and what they did then; a
# table that is not empty is of a group's settings.
ADDED: dict[str, Any] = {
    "start": "zero",
    "ramp": None,
    "test_settings": {},
    "pruning": None,
    "rewiring": None,
    "growth": None,
    "goal": {"fine_trials": 0, "fine_factor": 4, "share": 1.0},
    "env": {
        "min_speed": 0.0,
        "max_lag": 1e9,
        "body": "",
        "course": BY_DEFAULT,
        "push": BY_DEFAULT,
        "payload": BY_DEFAULT,
        "perturbation": 0.0,
        "acting": "torque",
        "action_noise": 0.0,
    },
    "controller": {
        "activation": "tanh",
        "layer_norm": False,
        "clock": None,
        "normalise": False,
        "limit": 5.0,
        "density": 1.0,
        "wiring_seed": 0,
    },
}


def of_run(run: Run) -> Any:
    """Returns the experiment of a run; imports JAX.

    Raises:
      RunError: this mjxwalk does not know it, its settings have changed, or it has code that this
        user does not trust.
    """
    code = run.code
    data = run.config["experiment"]
    task = None if code is None else own_task.of_run(run.path, code)
    try:
        return from_data(data, None if task is None else task.named(str(data.get("name"))))
    except (RunError, ValueError) as error:
        raise RunError(f"{run.path / config.FILE}: {error}") from None


def from_data(data: dict[str, Any], defaults: Any = None) -> Any:
    """Returns an experiment from its settings as plain data; imports JAX.

    Settings of older runs get their names of today, and those that they did not have are filled in.

    Args:
      data: the settings.
      defaults: an experiment of the same classes; None for the one of that name.

    Raises:
      RunError: a setting is unknown, missing or of a wrong type.
      ValueError: there is no experiment of that name.
    """
    if defaults is None:
        env = data.get("env")
        body = env.get("body", "") if isinstance(env, dict) else ""
        defaults = registry.get(str(data.get("name")), body if isinstance(body, str) else "")
    data = {RENAMED.get(name, name): value for name, value in data.items()}
    data = _with_added(data, ADDED, defaults)
    return settings.from_data(defaults, data, "experiment")


def _with_added(data: dict[str, Any], added: dict[str, Any], defaults: Any) -> dict[str, Any]:
    filled = dict(data)
    for name, value in added.items():
        if isinstance(value, dict) and value:
            if isinstance(data.get(name), dict):
                filled[name] = _with_added(data[name], value, getattr(defaults, name, None))
        elif dataclasses.is_dataclass(defaults) and name in _field_names(defaults):
            if value is BY_DEFAULT:
                value = settings.to_data(type(getattr(defaults, name))())
            filled.setdefault(name, value)
    return filled


def _field_names(settings: Any) -> set[str]:
    return {field.name for field in dataclasses.fields(settings)}
