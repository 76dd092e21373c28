"""Which walkers are shown: a run's best, one of a generation, its population, or its champions."""

import dataclasses
from pathlib import Path
from typing import Any

import jax
import numpy as np

from mjxwalk import experiments, runs, terminal, walkers
from mjxwalk.errors import RunError
from mjxwalk.runs import checkpoints, folder
from mjxwalk.tournament.entrants import Entrants
from mjxwalk.walker import Walker

RANKS = {
    "winner": "winner of the tournament",
    "champion": "champion",
    "fittest": "fittest so far",
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class ShownWalkers:
    """The walkers that are shown together.

    Attributes:
      source: of all, as text to show.
      what: they are, in a few words.
      experiment: that they evolved in.
      genotypes: leaves [walker, ...]; numpy.
      labels: of each, in a word or two.
    """

    source: str
    what: str
    experiment: Any
    genotypes: Any
    labels: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.labels)


def best(source: str | Path) -> ShownWalkers:
    """Returns the tournament's winner, else the champion, else the fittest so far.

    Raises:
      RunError: there is no such source, it has no walker yet, or it is a fit.
    """
    found = walkers.best(source)
    walkers.check_walks(source, found.experiment)
    return of_walker(found)


def of_walker(found: Walker) -> ShownWalkers:
    """Returns a walker alone."""
    return ShownWalkers(
        source=found.name,
        what=f"{RANKS[found.rank]}, generation {found.generation}",
        experiment=found.experiment,
        genotypes=_together([found.genotype]),
        labels=(f"generation {found.generation}",),
    )


def fittest(source: str | Path, generation: int) -> ShownWalkers:
    """Returns the fittest walker of a generation.

    Raises:
      RunError: the source has none of that generation.
    """
    known = _known(source)
    _check_there(source, generation, known)
    return ShownWalkers(
        source=terminal.one_line(str(source)),
        what=f"fittest of generation {generation}",
        experiment=known.experiment,
        genotypes=_together([known.genotype(generation)]),
        labels=(f"generation {generation}",),
    )


def population(source: str | Path, number: int, generation: int | None) -> ShownWalkers:
    """Returns the fittest walkers of a population, fittest first.

    Args:
      source: a run's folder.
      number: of walkers, at most; a population may have fewer.
      generation: of the population; None for the newest.

    Raises:
      RunError: the run does not have that population any more.
    """
    _check_is_run(source, "a population")
    path = Path(source)
    there = checkpoints.generations(path / folder.CHECKPOINTS)
    if generation is not None and generation not in there:
        raise RunError(
            f"{source} has no population of generation {generation} any more; it has "
            f"{ranges(there) or 'none yet'}, and mjxwalk evolve --keep all keeps all"
        )
    run = runs.load(path, generation)
    if run.generation == 0:
        raise RunError(f"{source} has not saved a generation yet")
    experiment = experiments.of_run(run)
    walkers.check_walks(source, experiment)
    fitness = np.where(np.isfinite(run.fitness), run.fitness, -np.inf)
    chosen = np.argsort(-fitness, kind="stable")[:number]
    arrays = {name: leaf[chosen] for name, leaf in run.population.items()}
    size = len(fitness)
    shown = "all" if len(chosen) == size else f"fittest {len(chosen)}"
    return ShownWalkers(
        source=terminal.one_line(str(source)),
        what=f"{shown} of {size} in generation {run.generation}",
        experiment=experiment,
        genotypes=_unflatten(path, experiment, arrays, len(chosen)),
        labels=tuple(f"rank {place + 1}" for place in range(len(chosen))),
    )


def champions(source: str | Path, number: int) -> ShownWalkers:
    """Returns the fittest of several generations, newest first.

    Args:
      source: a run's folder.
      number: of walkers, at most, spread evenly over the generations that the run still has.

    Raises:
      RunError: there is no such run, it has no walker yet, or it is a fit.
    """
    _check_is_run(source, "champions of several generations")
    known = _known(source)
    there = np.array(known.generations)
    places = np.linspace(len(there) - 1, 0, min(number, len(there))).round().astype(int)
    chosen = [int(generation) for generation in there[places]]
    return ShownWalkers(
        source=terminal.one_line(str(source)),
        what=f"champions from generation {chosen[-1]} to {chosen[0]}",
        experiment=known.experiment,
        genotypes=_together([known.genotype(generation) for generation in chosen]),
        labels=tuple(f"generation {generation}" for generation in chosen),
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Known:
    """The generations whose fittest walker can still be had.

    A run keeps the fittest of its last generations in every checkpoint, and the newest checkpoints.
    """

    source: str | Path
    experiment: Any
    elites: Entrants
    generations: tuple[int, ...]

    def genotype(self, generation: int) -> Any:
        """Returns the fittest walker of a generation."""
        if generation in self.elites.generations:
            return self.elites.of_generation(generation)
        path = Path(self.source)
        run = runs.load(path, generation)
        alone = {name: leaf[None] for name, leaf in run.elite.items()}
        found = _unflatten(path, self.experiment, alone, 1)
        return jax.tree.map(lambda leaf: leaf[0], found)


def _known(source: str | Path) -> _Known:
    elites = walkers.entrants(source)
    walkers.check_walks(source, elites.experiment)
    generations = {int(generation) for generation in elites.generations}
    if not walkers.in_zoo(source):
        generations |= set(checkpoints.generations(Path(source) / folder.CHECKPOINTS))
    return _Known(
        source=source,
        experiment=elites.experiment,
        elites=elites,
        generations=tuple(sorted(generations)),
    )


def _check_there(source: str | Path, generation: int, known: _Known) -> None:
    if generation not in known.generations:
        there = ranges(known.generations)
        raise RunError(f"{source} has no walker of generation {generation}; it has {there}")


def _check_is_run(source: str | Path, what: str) -> None:
    if walkers.in_zoo(source):
        raise RunError(f"{source} is one walker and has no {what.removeprefix('a ')}; name a run")


def ranges(generations: Any) -> str:
    """Returns numbers in words, such as "generation 3 and 7 to 9"."""
    spans: list[list[int]] = []
    for generation in generations:
        if spans and generation == spans[-1][-1] + 1:
            spans[-1] = [spans[-1][0], generation]
        else:
            spans.append([generation])
    texts = [" to ".join(map(str, span)) for span in spans]
    if len(texts) > 4:
        texts = [*texts[:2], "others", texts[-1]]
    return f"generation {', '.join(texts)}" if texts else ""


def _together(genotypes: list[Any]) -> Any:
    return jax.tree.map(lambda *leaves: np.stack([np.asarray(leaf) for leaf in leaves]), *genotypes)


def _unflatten(path: Path, experiment: Any, arrays: Any, number: int) -> Any:
    several = jax.tree.map(
        lambda leaf: jax.ShapeDtypeStruct((number, *leaf.shape), leaf.dtype), experiment.template()
    )
    try:
        return runs.unflatten(several, arrays)
    except RunError as error:
        raise RunError(f"{path} holds walkers of another experiment: {error}") from None
