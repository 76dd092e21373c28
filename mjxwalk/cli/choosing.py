"""From the arguments of `mjxwalk evolve` to the settings of a run or of a study; imports JAX."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from mjxwalk import experiments
from mjxwalk.cli import own_body
from mjxwalk.cli.evolve_arguments import EvolveArguments
from mjxwalk.errors import RunError, near
from mjxwalk.evolution import evolvable
from mjxwalk.evolution.inheritance import inherit
from mjxwalk.experiments.run_config import Config
from mjxwalk.experiments.scaling import scaled
from mjxwalk.experiments.study_config import StudyConfig
from mjxwalk.fitting import Fitting
from mjxwalk.runs import files
from mjxwalk.runs.inheritance import Inherited
from mjxwalk.settings import override
from mjxwalk.strategies import carry_over

# Flags that stand for a setting of the experiment.
SETTINGS = {
    "generations": "generations",
    "population": "population_size",
    "terrains": "terrains_per_evaluation",
    "roughness": "env.terrain.roughness",
}
CONTACT_LAW = "env.contact_law"  # comes before others, as a time step goes with it


def choose_run(asked: EvolveArguments) -> tuple[Config, Inherited | None]:
    """Returns the settings of a run and what it starts from, None for zero.

    Raises:
      RunError: a setting is unknown or has a wrong value, or the run cannot start from what it
        was told to.
    """
    experiment = _with_flags(asked, scaled(_experiment(asked), asked.scale))
    if asked.strategy is not None:
        experiment = _with_strategy(asked.strategy, experiment)
    for path, value in sorted(_assignments(asked), key=lambda each: each[0] != CONTACT_LAW):
        experiment = _override(experiment, path, value)
    if asked.links is not None:
        experiment = override(experiment, "controller.links", _read_links(asked.links))
    if asked.source is not None and experiment.start == "zero":
        experiment = override(experiment, "start", "winner")
    evolvable.check(experiment)
    try:
        settings = Config(
            experiment=experiment,
            seed=asked.seed,
            engine=asked.engine,
            keep=asked.keep,
            save_every=asked.save_every or _save_every(experiment),
        )
    except (ValueError, TypeError) as error:
        raise RunError(str(error)) from None
    _read_target(experiment)
    if experiment.start == "zero":
        return settings, None
    if asked.source is None:
        raise RunError(
            f"{experiment.name} starts from the {experiment.start} of another run; name it with "
            "--from RUN"
        )
    inherited, origin = inherit(experiment, asked.source)
    return dataclasses.replace(settings, origin=origin), inherited


def _experiment(asked: EvolveArguments) -> Any:
    """Returns the experiment that is asked for, with the controller that is.

    Raises:
      RunError: it takes no other.
    """
    chosen = f"{asked.experiment}+{asked.controller}" if asked.controller else asked.experiment
    try:
        return experiments.get(chosen)
    except ValueError as error:
        raise RunError(str(error)) from None


def _override(experiment: Any, path: str, value: str) -> Any:
    """Returns the experiment with a setting, which is not its name: its run is read by that.

    Raises:
      RunError: it is its name, or as `settings.override` has it.
    """
    if path == "name":
        raise RunError(f"name is no setting: a run of {experiment.name} is read by it; leave it")
    experiment = override(experiment, path, value)
    # So that it is the same as --contact: each law has a time step of its own.
    return own_body.with_contact(experiment, value) if path == CONTACT_LAW else experiment


def _read_target(experiment: Any) -> None:
    """Reads what a fit is fitted to, so that what is wrong with it is told before its run is made.

    Raises:
      RunError: it cannot be read.
    """
    if isinstance(experiment, Fitting):
        experiment.describe()


def choose_study(asked: EvolveArguments) -> StudyConfig:
    """Returns the settings of a study.

    Raises:
      RunError: a setting is unknown or has a wrong value.
    """
    study = experiments.get_study(asked.experiment).scaled(asked.scale)
    phases = {name: _with_flags(asked, experiment) for name, experiment in study.phases}
    for path, value in _assignments(asked):
        name, _, rest = path.partition(".")
        if name not in phases or not rest:
            raise RunError(
                f"--set of a study needs PHASE.PATH=VALUE, got {path}={value}{near(name, phases)}"
            )
        phases[name] = _override(phases[name], rest, value)
    if asked.links is not None:
        phases = _with_links(asked, phases, _read_links(asked.links))
    for experiment in phases.values():
        evolvable.check(experiment)
    try:
        return StudyConfig(
            name=study.name,
            phases=tuple(phases.items()),
            seed=asked.seed,
            engine=asked.engine,
            keep=asked.keep,
            save_every=asked.save_every or 1,
            scale=asked.scale,
        )
    except (ValueError, TypeError) as error:
        raise RunError(str(error)) from None


def _save_every(experiment: Any) -> int:
    return experiment.save_every if isinstance(experiment, Fitting) else 1


def _with_flags(asked: EvolveArguments, experiment: Any) -> Any:
    """Returns the experiment with the body and the settings that have flags of their own."""
    if asked.body is not None:
        experiment = own_body.put(experiment, asked.body)
    if asked.contact is not None:
        experiment = own_body.with_contact(experiment, asked.contact)
    for flag, path in SETTINGS.items():
        value = getattr(asked, flag)
        if value is not None:
            experiment = override(experiment, path, str(value))
    if asked.generations is not None and experiment.goal.trials:
        experiment = override(experiment, "goal.trials", "0")
    return experiment


def _with_strategy(name: str, experiment: Any) -> Any:
    """Returns the experiment with another strategy, and what the two have in common."""
    try:
        options = carry_over(name, experiment.strategy.options)
    except ValueError as error:
        raise RunError(str(error)) from None
    strategy = dataclasses.replace(experiment.strategy, name=name, options=options)
    return dataclasses.replace(experiment, strategy=strategy)


def _with_links(asked: EvolveArguments, phases: dict[str, Any], links: str) -> dict[str, Any]:
    """Returns the phases with the links put in where there is a table of them already."""
    with_table = {
        name: override(experiment, "controller.links", links)
        for name, experiment in phases.items()
        if isinstance(getattr(experiment.controller, "links", None), Mapping)
    }
    if not with_table:
        raise RunError(f"no phase of {asked.experiment} takes its links from a table")
    return phases | with_table


def _assignments(asked: EvolveArguments) -> list[tuple[str, str]]:
    pairs = [assignment.partition("=") for assignment in asked.set]
    given = [(path.strip(), value.strip()) for path, _, value in pairs]
    for path, _ in given:
        if path.endswith("env.body"):
            raise RunError("env.body goes with settings that belong to it; use --body FILE")
        if "controller.layout" in path:
            raise RunError(f"{path} is no setting: it follows from the body; leave it")
    return given


def _read_links(path: Path) -> str:
    """Returns a table of links as JSON text.

    Raises:
      RunError: the file cannot be read, or is no such table.
    """
    try:
        content = files.read(path, files.MOST_JSON)
        table = msgspec.json.decode(content, type=dict[str, list[str]])
    except files.MALFORMED as error:
        raise RunError(
            f"{path} must hold a table of inputs by network, such as "
            f'{{"torso": ["inter-leg"]}}: {error}'
        ) from None
    return msgspec.json.encode(table).decode()
