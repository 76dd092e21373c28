"""What a run that does not start from zero starts from: taken from another run, and checked."""

from pathlib import Path
from typing import Any

import jax
import numpy as np

from mjxwalk import experiments, runs, terminal, walkers
from mjxwalk.controllers.normalisation import Normalised
from mjxwalk.evolution import sensed
from mjxwalk.evolution.evolvable import Evolvable
from mjxwalk.experiments import own_task
from mjxwalk.runs import Run, RunError
from mjxwalk.runs.config import Origin
from mjxwalk.runs.inheritance import Arrays, Inherited
from mjxwalk.runs.trees import flatten, unflatten


def inherit(experiment: Evolvable, source: str | Path) -> tuple[Inherited, Origin]:
    """Returns what an experiment starts from, and where it comes from.

    Args:
      experiment: that starts from a winner or a population.
      source: a run's folder; of a winner also `zoo:NAME`.

    Raises:
      RunError: there is no such source, it is damaged or has saved nothing yet, or it is of
        another body, controller or strategy.
    """
    if experiment.start == "winner":
        return _winner(experiment, source)
    run = _evolved(experiment, source)
    if experiment.start == "mean":
        return _mean(experiment, run)
    return _population(experiment, run)


def _winner(experiment: Evolvable, source: str | Path) -> tuple[Inherited, Origin]:
    walker = walkers.best(source)
    _check_kind(experiment, walker.experiment, source)
    inherited = _around(experiment, flatten(walker.genotype), source)
    return inherited, Origin(source=terminal.one_line(str(source)), generation=walker.generation)


def _mean(experiment: Evolvable, run: Run) -> tuple[Inherited, Origin]:
    mean = {
        name: np.mean(leaf, axis=0, dtype=np.float64).astype(leaf.dtype)
        for name, leaf in run.population.items()
    }
    inherited = _around(experiment, mean, run.path)
    return inherited, Origin(source=terminal.one_line(str(run.path)), generation=run.generation)


def _around(experiment: Evolvable, genotype: Arrays, source: str | Path) -> Inherited:
    try:
        unflatten(experiment.template(), genotype)
    except RunError as error:
        raise RunError(_misfit(experiment, source, error)) from None
    return Inherited(genotype, {}, np.zeros(0, np.float32))


def _evolved(experiment: Evolvable, source: str | Path) -> Run:
    """Returns the run whose last population is to be started from."""
    if walkers.in_zoo(source):
        raise RunError(
            f"{source} is a single walker, and this experiment starts from the whole population "
            "of a run; name a run's folder"
        )
    run = runs.load(source)
    for reason in run.damaged.values():
        raise RunError(reason)
    if run.generation == 0:
        raise RunError(f"{source} has not saved a generation yet")
    _check_kind(experiment, experiments.of_run(run), source)
    return run


def _population(experiment: Evolvable, run: Run) -> tuple[Inherited, Origin]:
    source, elites = run.path, run.part("elites")
    inherited = Inherited(
        {},
        _innermost(run.strategy_state),
        elites["fitness"][elites["generation"] > 0],
        run.part("sensed"),
    )
    strategy = experiment.make_strategy()
    if run.fitness.size != strategy.population_size:
        raise RunError(
            f"{source} has a population of {run.fitness.size} and this experiment one of "
            f"{strategy.population_size}; set --population {run.fitness.size}"
        )

    def begin(key: Any, template: Any) -> Any:
        state = strategy.init(key, template)
        return experiment.take_over(strategy, state, inherited.strategy, inherited.elite_fitness)

    try:
        jax.eval_shape(begin, jax.random.key(0), experiment.template())
        unflatten(sensed.begin(experiment.template()), inherited.sensed)
    except RunError as error:
        raise RunError(_misfit(experiment, source, error)) from None
    return inherited, Origin(source=terminal.one_line(str(source)), generation=run.generation)


def _innermost(arrays: Arrays) -> Arrays:
    """Returns a strategy's own state without those of what wraps it."""
    while any(name.startswith("inner.") for name in arrays):
        inside = {name: array for name, array in arrays.items() if name.startswith("inner.")}
        arrays = {name.removeprefix("inner."): array for name, array in inside.items()}
    return arrays


def _check_kind(experiment: Evolvable, other: Any, source: str | Path) -> None:
    """Refuses weights of another kind of controller, whatever their shapes."""
    templates = experiment.template(), other.template()
    has_senses = [isinstance(template, Normalised) for template in templates]
    if has_senses[0] != has_senses[1]:
        is_now, was = (str(each).lower() for each in has_senses)
        raise RunError(
            f"{source} evolved with controller.normalise={was} and this experiment has {is_now}, "
            f"so it cannot start from it; --set controller.normalise={was}"
        )
    ours, theirs = (
        type(template.weights if isinstance(template, Normalised) else template)
        for template in templates
    )
    if ours is not theirs and not _are_own(ours, theirs):
        raise RunError(
            f"{source} holds the weights of another controller ({theirs.__module__} has "
            f"{theirs.__name__}, {ours.__module__} {ours.__name__}), so this experiment cannot "
            "start from it"
        )


def _are_own(ours: type, theirs: type) -> bool:
    """Returns whether two classes of one name are of a user's own tasks, perhaps of two texts."""
    both = (ours, theirs)
    return len({each.__qualname__ for each in both}) == 1 and all(
        each.__module__.startswith(own_task.MODULE) for each in both
    )


def _misfit(experiment: Evolvable, source: str | Path, error: RunError) -> str:
    return f"this experiment ({experiment.start} as its start) cannot start from {source}: {error}"
