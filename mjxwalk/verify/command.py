"""The command `mjxwalk verify`."""

import dataclasses
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

import tyro

from mjxwalk import budget, outputs
from mjxwalk.cli.parsing import OptionalFloat, Seed
from mjxwalk.errors import RunError
from mjxwalk.tournament.command import Source

TERRAINS = 20
# Folded into the seed's key, it leads away from the keys of runs, tournaments and analyses.
VERIFY = 0x76657269
DISAGREES = 1  # exit code

EngineName: TypeAlias = Literal["as-evolved", "auto", "mjx", "lanes", "lanes-xla"]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Verify:
    """Walk a run's best walker again in C MuJoCo, in float64, and compare with its engine.

    Kinematics, mass matrix and bias forces are C MuJoCo's; ground, joint stops, senses and the
    rules of a trial are computed anew in float64, from code that shares nothing with the engine's.
    Shared are the body's XML, the settings, the terrains, the starts, and the controller's source,
    which JAX compiles for float64. The exit code is 0 if the two agree, 1 if they do not.

    Attributes:
      source: folder of a run, finished or not, or a walker that ships with mjxwalk.
      terrains: on which it walks, new to it.
      seed: of the terrains.
      engine: what to compare with; as-evolved is the one that evolved the walker.
      roughness: step of the random terrain, m.
      json: file to write the figures to; an old one is replaced.
    """

    source: Source
    terrains: int = TERRAINS
    seed: Seed = 0
    engine: EngineName = "as-evolved"
    roughness: OptionalFloat = None
    json: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None

    def run(self) -> int:
        """Compares, shows what came out, and returns the exit code.

        Raises:
          RunError: an argument is wrong, or the walker's body is none that C MuJoCo is set up for.
        """
        self._check()
        from mjxwalk import engines, walkers
        from mjxwalk.tournament.results import as_json
        from mjxwalk.verify import comparing, showing

        engines.prepare()
        walker = walkers.best(self.source)
        try:
            agreement = comparing.verify(
                walker,
                engine=self._engine(),
                terrains=self.terrains,
                seed=self.seed,
                roughness=self.roughness,
                say=_say,
            )
        except ValueError as error:
            raise RunError(str(error)) from None
        showing.show(agreement)
        if self.json is not None:
            outputs.write(self.json, as_json(agreement))
            _say(f"wrote {self.json}")
        return 0 if agreement.agrees else DISAGREES

    def _check(self) -> None:
        """Finds wrong arguments that can be found without the second that importing JAX takes."""
        from mjxwalk import walkers

        if self.terrains < 1:
            raise RunError(f"--terrains must be at least 1, got {self.terrains}")
        budget.check_asked("--terrains", self.terrains)
        if self.roughness is not None and self.roughness < 0:
            raise RunError(f"--roughness must not be negative, got {self.roughness}")
        walkers.check(self.source)
        if self.json is not None:
            outputs.check(self.json, "--json")

    def _engine(self) -> str:
        """Returns the engine to compare with."""
        if self.engine != "as-evolved":
            return self.engine
        from mjxwalk import runs, walkers, zoo

        if walkers.in_zoo(self.source):
            return zoo.provenance(self.source.removeprefix(walkers.ZOO)).engine
        return runs.load(self.source).manifest.get("engine", "auto")


def _say(text: str) -> None:
    print(text, flush=True)
