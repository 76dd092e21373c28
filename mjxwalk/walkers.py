"""Where walkers come from: a run's folder, or those that ship with mjxwalk as `zoo:NAME`."""

from pathlib import Path
from typing import Any

import numpy as np

from mjxwalk import experiments, runs, shell, terminal, zoo
from mjxwalk.errors import RunError
from mjxwalk.experiments import own_task
from mjxwalk.fitting import Fitting
from mjxwalk.runs import config, folder
from mjxwalk.tournament import results
from mjxwalk.tournament.entrants import Entrants
from mjxwalk.walker import Walker


def in_zoo(source: str | Path) -> bool:
    """Returns whether a source is an entry of the zoo, there or not, and not a folder."""
    return str(source).startswith(zoo.PREFIX)


def zoo_name(source: str | Path) -> str:
    """Returns the name of an entry of the zoo without what tells that it is one."""
    return str(source).removeprefix(zoo.PREFIX)


def check(source: str | Path, *, trust: bool = False) -> None:
    """Raises RunError unless there is such a source, whose code is trusted; imports no JAX.

    Args:
      source: a run's folder, or `zoo:NAME`.
      trust: whether the user said to trust the code of the run, if it has any.
    """
    if in_zoo(source):
        zoo.check(zoo_name(source))
    else:
        _check_run(Path(source))
        own_task.trust.check_run(Path(source), is_given=trust)


def entrants(source: str | Path) -> Entrants:
    """Returns the elites of a run's last generations, or the one walker of a zoo's entry.

    Args:
      source: a run's folder, finished or not, or `zoo:NAME`.

    Raises:
      RunError: there is no such source, it has no walker yet, or its files are damaged.
    """
    import jax

    if in_zoo(source):
        walker = best(source)
        alone = jax.tree.map(lambda leaf: np.asarray(leaf)[None], walker.genotype)
        return Entrants(
            name=walker.name,
            experiment=walker.experiment,
            genotypes=alone,
            generations=np.array([walker.generation]),
        )
    run = _load(Path(source))
    experiment = experiments.of_run(run)
    generations = run.part("elites")["generation"]
    taken = generations > 0
    arrays = {name: leaf[taken] for name, leaf in run.elites.items()}
    size = int(taken.sum())
    several = jax.tree.map(
        lambda leaf: jax.ShapeDtypeStruct((size, *leaf.shape), leaf.dtype), experiment.template()
    )
    return Entrants(
        name=terminal.one_line(str(source)),
        experiment=experiment,
        genotypes=_fitting(run.path, several, arrays),
        generations=generations[taken],
    )


def best(source: str | Path) -> Walker:
    """Returns the tournament's winner of a source, else its champion, else its fittest so far.

    Args:
      source: a run's folder, finished or not, or `zoo:NAME`. A run that has gone on since its
        tournament has no winner.

    Raises:
      RunError: there is no such source, it has no walker yet, or its files are damaged.
    """
    if in_zoo(source):
        return zoo.load(zoo_name(source))
    run = _load(Path(source))
    found = results.read(run.path)
    if found is not None and found.newest_generation == run.generation:
        arrays, rank, generation = results.read_winner(run.path), "winner", found.winner_generation
    elif run.result is not None:
        arrays, rank, generation = run.champion, "champion", run.result.champion.generation
    else:
        arrays, rank, generation = run.elite, "fittest", run.generation
    experiment = experiments.of_run(run)
    return Walker(
        name=terminal.one_line(str(source)),
        rank=rank,
        experiment=experiment,
        genotype=_fitting(run.path, experiment.template(), arrays),
        generation=generation,
    )


def check_walks(source: str | Path, experiment: Any) -> None:
    """Raises unless walkers of an experiment walk.

    Args:
      source: where they are from, for the error.
      experiment: that they evolved in.

    Raises:
      RunError: it is a fit.
    """
    if isinstance(experiment, Fitting):
        report = shell.command("report", Path(source))
        raise RunError(f"{source} is a fit, in which nothing walks; see {report}")


def check_has_anatomy(source: str | Path, experiment: Any) -> None:
    """Raises unless walkers of an experiment walk, with a body whose anatomy is known.

    Args:
      source: where they are from, for the error.
      experiment: that they evolved in.

    Raises:
      RunError: it is a fit, or its environment is no `LeggedEnv`.
    """
    from mjxwalk.envs import LeggedEnv

    check_walks(source, experiment)
    env = getattr(experiment, "env", None)
    if not isinstance(env, LeggedEnv):
        raise RunError(
            f"{source} has the environment {type(env).__name__}, which says nothing of its body; "
            "derive it from mjxwalk.envs.LeggedEnv"
        )


def _check_run(path: Path) -> None:
    if path.is_dir() and not (path / config.FILE).exists():
        inside = sorted(str(each.parent) for each in path.glob(f"*/{config.FILE}"))
        if inside:
            raise RunError(f"{path} holds several runs; name one of {', '.join(inside)}")
    folder.check_run(path)


def _load(path: Path) -> runs.Run:
    """Returns a run that has a generation.

    Raises:
      RunError: it has none, or the folder is not a run's.
    """
    _check_run(path)
    run = runs.load(path)
    if run.generation == 0:
        for reason in run.damaged.values():
            raise RunError(f"{path} has no checkpoint that can be read: {reason}")
        raise RunError(f"{path} has not saved a generation yet")
    return run


def _fitting(path: Path, template: Any, arrays: dict[str, Any]) -> Any:
    try:
        return runs.unflatten(template, arrays)
    except RunError as error:
        raise RunError(f"{path} holds walkers of another experiment: {error}") from None
