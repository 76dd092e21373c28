"""Makes an entry of the zoo from a run and its tournament."""

from pathlib import Path

import mjxwalk
from mjxwalk import runs, settings, shell, walkers
from mjxwalk.errors import RunError
from mjxwalk.experiments import repeating
from mjxwalk.runs.trees import flatten
from mjxwalk.tournament import results
from mjxwalk.zoo import entries
from mjxwalk.zoo.entries import Provenance


def ship(path: Path, name: str, zoo: Path, *, command: str | None = None) -> Provenance:
    """Writes the winner of a run's tournament into a zoo.

    Args:
      path: the run's folder.
      name: of the entry; an old one is replaced.
      zoo: folder of the entries.
      command: that made the run; None for what its settings tell.

    Raises:
      RunError: no tournament was held since the run's last generation, what the run started from
        is not known, the name is no file's, or the files cannot be written.
    """
    if not name or not all(part.isalnum() for part in name.split("-")):
        raise RunError(f"a walker's name is letters, digits and hyphens, got {name!r}")
    walker = walkers.best(path)
    held = results.read(path)
    if held is None or walker.rank != "winner":
        raise RunError(
            f"{path} has no winner; hold a tournament: {shell.command('tournament', path)}"
        )
    run = runs.load(path)
    provenance = Provenance(
        schema=entries.SCHEMA,
        experiment=settings.to_data(walker.experiment),
        seed=run.config["seed"],
        generation=walker.generation,
        engine=run.manifest.get("engine", run.config["engine"]),
        mjxwalk=run.manifest.get("mjxwalk", mjxwalk.__version__),
        commit=run.manifest.get("commit"),
        command=command or repeating.command(run, walker.experiment),
        tournament=held,
    )
    entries.write(zoo, name, provenance, flatten(walker.genotype))
    return provenance
