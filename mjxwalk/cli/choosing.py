"""From the arguments of `mjxwalk evolve` to the settings of a run or of a study; imports JAX."""

import dataclasses
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from mjxwalk import experiments
from mjxwalk.cli import own_body
from mjxwalk.cli.evolve_arguments import EvolveArguments
from mjxwalk.errors import RunError, near
from mjxwalk.evolution import evolvable
from mjxwalk.evolution.inheritance import inherit
from mjxwalk.experiments import own_task
from mjxwalk.experiments.own_task import trying
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
OF_BODIES = ("controller.period", "controller.moved", "controller.rates")  # of a `Policy`


class Chosen(NamedTuple):
    """What a run is made of: the arguments of `Runner.evolve_run` behind its folder.

    Attributes:
      settings: of the run.
      inherited: what it starts from; None for zero.
      task: text of a user's own task; None of our own experiments.
    """

    settings: Config
    inherited: Inherited | None
    task: bytes | None


def choose_run(asked: EvolveArguments) -> Chosen:
    """Returns what a run is made of.

    Raises:
      RunError: a setting is unknown or has a wrong value, the run cannot start from what it was
        told to, or a user's own task has an error.
    """
    task = own_task.of_user(asked.experiment) if asked.is_task else None
    if task is not None:
        _check_text(asked, task)
    experiment = _with_flags(asked, _scaled(_experiment(asked, task), asked.scale))
    if asked.strategy is not None:
        experiment = _with_strategy(asked.strategy, experiment)
    given = sorted(_assignments(asked), key=lambda each: each[0] != CONTACT_LAW)
    experiment = _with_settings(experiment, given)
    if asked.links is not None:
        experiment = override(experiment, "controller.links", _read_links(asked.links))
    if asked.source is not None and experiment.start == "zero":
        experiment = override(experiment, "start", "winner")
    if task is not None:
        trying.check(task, experiment, most_steps=asked.most_steps)
    evolvable.check(experiment)
    try:
        settings = Config(
            code=None if task is None else task.code,
            experiment=experiment,
            seed=asked.seed,
            engine=asked.engine,
            keep=asked.keep,
            save_every=asked.save_every or _save_every(experiment),
        )
    except (ValueError, TypeError) as error:
        raise RunError(str(error)) from None
    _read_target(experiment)
    if task is not None:
        own_task.trust.trust(task.code.sha256, task.code.file)
    text = None if task is None else task.text.content
    if experiment.start == "zero":
        return Chosen(settings, None, text)
    if asked.source is None:
        raise RunError(
            f"{experiment.name} starts from the {experiment.start} of another run; name it with "
            "--from RUN"
        )
    inherited, origin = inherit(experiment, asked.source)
    return Chosen(dataclasses.replace(settings, origin=origin), inherited, text)


def _check_text(asked: EvolveArguments, task: own_task.Task) -> None:
    """Raises RunError unless a text is the one that a sweep began with; says what is not kept."""
    began = asked.task_sha256
    if began is not None and began != task.code.sha256:
        raise RunError(
            f"{task.text.shown} was changed since the sweep began: its sha256 is "
            f"{task.code.sha256[:16]}... and the sweep began with {began[:16]}...; put back the "
            "text as it was, or begin another sweep"
        )
    if task.beside:
        print(
            f"{task.text.shown} imports {', '.join(task.beside)} from its folder; the run keeps "
            f"{task.code.file} alone, so commands on the run need them on PYTHONPATH",
            file=sys.stderr,
        )


def _scaled(experiment: Any, scale: float) -> Any:
    # An experiment of another kind may have no population_size to scale.
    return experiment if scale == 1.0 else scaled(experiment, scale)


def _experiment(asked: EvolveArguments, task: own_task.Task | None) -> Any:
    """Returns the experiment that is asked for, with the controller that is.

    Args:
      asked: what is.
      task: of the user's own; None of our own experiments.

    Raises:
      RunError: it takes no other.
    """
    name = asked.experiment if task is None else task.experiment.name
    chosen = f"{name}+{asked.controller}" if asked.controller else name
    try:
        return experiments.get(chosen) if task is None else task.named(chosen)
    except ValueError as error:
        raise RunError(str(error)) from None


def _with_settings(experiment: Any, settings: list[tuple[str, str]]) -> Any:
    """Returns the experiment with settings; one that is refused waits until the others are in.

    So their order does not count where one has to be at most another.

    Raises:
      RunError: one is refused with all others in.
    """
    while settings:
        refused: dict[tuple[str, str], RunError] = {}
        for path, value in settings:
            try:
                experiment = _override(experiment, path, value)
            except RunError as error:
                refused[path, value] = error
        if len(refused) == len(settings):
            raise next(iter(refused.values()))
        settings = list(refused)
    return experiment


def _override(experiment: Any, path: str, value: str) -> Any:
    """Returns the experiment with a setting, which is not its name: its run is read by that.

    Raises:
      RunError: it is its name, or as `settings.override` has it.
    """
    if path == "name":
        raise RunError(f"name is no setting: a run of {experiment.name} is read by it; leave it")
    if path in OF_BODIES and not hasattr(getattr(experiment, "env", None), "anatomy"):
        raise RunError(
            f"{path} is for bodies of files and ours: in {experiment.name} all actions move, at "
            "every step; leave it"
        )
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
