"""Which command makes a run again, from the settings in its folder."""

import json
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mjxwalk import experiments, settings
from mjxwalk.experiments import own_body, own_task, study_config
from mjxwalk.runs import Run, study, task_file


def command(run: Run, experiment: Any) -> str:
    """Returns the command that makes a run, or the study that it is a phase of, once more.

    Args:
      run: as it is on disk.
      experiment: that was run.

    Raises:
      RunError: the study's settings cannot be read.
      ValueError: there is no such experiment or study any more.
    """
    whole = run.path.resolve().parent
    if study.is_study(whole):
        return _of_study(whole)
    task = None if run.code is None else own_task.of_run(run.path, run.code)
    # Of a user's own task the run has the file.
    name, _, controller = experiment.name.partition("+")
    name = name if task is None else f"{run.path / task_file.FILE}:{task.code.name}"
    words = ["mjxwalk", "evolve", name, "--seed", str(run.config["seed"])]
    if controller:
        words += ["--controller", controller]
    origin = run.config.get("origin")
    if origin is not None:
        words += ["--from", str(origin["source"])]
    named, text = experiment.name, _body(experiment)
    usual = experiments.get(named, text) if task is None else task.named(named)
    if text != _body(usual):
        words += ["--body", str(run.path)]
        usual = own_body.with_body(usual, text)
    return shlex.join([*words, *_changes(usual, experiment)])


def _body(experiment: Any) -> str:
    """Returns the XML of a user's body, "" where the body is ours."""
    return getattr(getattr(experiment, "env", None), "body", "")


def _of_study(path: Path) -> str:
    made = study_config.read(path)
    usual = experiments.get_study(made.name).scaled(made.scale)
    words = ["mjxwalk", "evolve", made.name, "--seed", str(made.seed)]
    if made.scale != 1.0:
        words += ["--scale", str(made.scale)]
    texts = {_body(experiment) for _, experiment in made.phases}
    if texts != {""}:
        words += ["--body", str(made.folder(path, 0))]
    for name, experiment in made.phases:
        phase, text = usual.phase(name), _body(experiment)
        phase = own_body.with_body(phase, text) if text != _body(phase) else phase
        words += _changes(phase, experiment, f"{name}.")
    return shlex.join(words)


def _changes(usual: Any, experiment: Any, prefix: str = "") -> list[str]:
    """Returns the arguments that turn one experiment into another of the same name."""
    words: list[str] = []
    for path, value in _differences(settings.to_data(usual), settings.to_data(experiment), ""):
        words += [
            "--set",
            f"{prefix}{path}={value if isinstance(value, str) else json.dumps(value)}",
        ]
    return words


def _differences(usual: Any, data: Any, path: str) -> Iterator[tuple[str, Any]]:
    if isinstance(usual, dict) and isinstance(data, dict):
        for name, value in data.items():
            yield from _differences(usual.get(name), value, f"{path}.{name}" if path else name)
    elif data != usual:
        yield path, data
