"""The command `mjxwalk tournament`."""

import dataclasses
import os
from pathlib import Path
from typing import TYPE_CHECKING

from mjxwalk import budget, outputs, shell
from mjxwalk.cli.argument_types import EngineName, OptionalFile, OptionalFloat, Seed, Source
from mjxwalk.errors import RunError
from mjxwalk.terminal import say
from mjxwalk.tournament import TERRAINS

if TYPE_CHECKING:
    from mjxwalk.tournament import Tournament
    from mjxwalk.tournament.entrants import Entrants


@dataclasses.dataclass(frozen=True, kw_only=True)
class HoldTournament:
    """Find a run's best walker on new terrains, and try it on others, at other steps and starts.

    The elites of the last generations compete. A run's folder gets tournament.json and winner.npz;
    a walker of the zoo is only tried, and so is a run on ground that it did not evolve on.

    Attributes:
      source: folder of a run, finished or not, or a walker that ships with mjxwalk.
      terrains: new terrains that the winner is tried on.
      seed: of terrains and starts.
      engine: what runs the trials; auto takes the fastest on this machine.
      roughness: step of the random terrain, m.
      json: file to write the figures to; an old one is replaced.
      trust: execute the code of the run, which somebody else wrote.
    """

    source: Source
    terrains: int = TERRAINS
    seed: Seed = 0
    engine: EngineName = "auto"
    roughness: OptionalFloat = None
    json: OptionalFile = None
    trust: bool = False

    def run(self) -> int:
        """Holds the tournament, shows and writes what came out, and returns the exit code.

        Raises:
          RunError: an argument is wrong, or there are no walkers.
        """
        self._check()
        from mjxwalk import engines, tournament, walkers
        from mjxwalk.cli import tournament_table
        from mjxwalk.fitting import Fitting

        engines.prepare()
        entrants = walkers.entrants(self.source)
        if isinstance(entrants.experiment, Fitting):
            raise RunError(
                f"{self.source} is a fit, whose figures know no chance, so there is nothing to "
                f"compete in; see {shell.command('report', Path(self.source))}"
            )
        changed = self._on_ground(entrants)
        try:
            figures = tournament.compete(
                changed,
                engine=self.engine,
                seed=self.seed,
                terrains=self.terrains,
                say=say,
            )
        except ValueError as error:
            raise RunError(str(error)) from None
        tournament_table.show(figures, self.source)
        elsewhere = changed.experiment.as_tested() != entrants.experiment.as_tested()
        self._write(figures, entrants, elsewhere=elsewhere)
        return 0

    def _check(self) -> None:
        """Finds wrong arguments that can be found without the second that importing JAX takes."""
        from mjxwalk import walkers
        from mjxwalk.runs import files

        if self.terrains < 1:
            raise RunError(f"--terrains must be at least 1, got {self.terrains}")
        budget.check_asked("--terrains", self.terrains)
        walkers.check(self.source, trust=self.trust)
        if self.json is not None:
            outputs.check(self.json, "--json")
        elif not walkers.in_zoo(self.source) and self.roughness is None:
            files.check_writable(Path(self.source), "; name a file for the figures with --json")

    def _on_ground(self, entrants: "Entrants") -> "Entrants":
        if self.roughness is None:
            return entrants
        from mjxwalk.settings import override

        experiment = override(
            entrants.experiment.as_tested(), "env.terrain.roughness", str(self.roughness)
        )
        return dataclasses.replace(entrants, experiment=experiment)

    def _write(self, figures: "Tournament", entrants: "Entrants", *, elsewhere: bool) -> None:
        from mjxwalk import tournament, walkers
        from mjxwalk.tournament import results

        if self.json is not None:
            outputs.write(self.json, outputs.as_json(figures))
            say(f"wrote {self.json}")
        if walkers.in_zoo(self.source):
            return
        if elsewhere:
            say(f"{self.source} is left as it is: it evolved on ground of another roughness")
            return
        if self.json is not None and not os.access(self.source, os.W_OK):
            say(f"{self.source} is left as it is: it cannot be written")
            return
        winner = entrants.of_generation(figures.winner_generation)
        tournament.write(Path(self.source), figures, winner)
        say(f"wrote {results.FILE} and {results.WINNER_FILE} in {self.source}")
