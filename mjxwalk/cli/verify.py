"""The command `mjxwalk verify`."""

import dataclasses
from typing import Literal

from mjxwalk import budget, outputs, terminal
from mjxwalk.cli.argument_types import (
    EngineName,
    OptionalFile,
    OptionalFloat,
    OtherContactLaw,
    Seed,
    Source,
)
from mjxwalk.errors import RunError

TERRAINS = 20
DISAGREES = 1  # exit code


@dataclasses.dataclass(frozen=True, kw_only=True)
class Verify:
    """Walk a run's best walker again in C MuJoCo, in float64, and compare with its engine.

    Kinematics, mass matrix and bias forces are C MuJoCo's; ground, joints, motors, senses and the
    rules of a trial are computed anew in float64, from code that shares nothing with the engine's.
    Shared are the body's XML, the settings, the terrains, the starts, and the controller's source,
    which JAX compiles for float64. The exit code is 0 if the two agree, 1 if they do not.

    Attributes:
      source: folder of a run, finished or not, or a walker that ships with mjxwalk.
      terrains: on which it walks, new to it.
      seed: of the terrains.
      engine: what to compare with; as-evolved is the one that evolved the walker.
      roughness: step of the random terrain, m.
      contact: law under which C MuJoCo walks, another than that of the engine: points, or mujoco
        for MuJoCo's own contacts.
      json: file to write the figures to; an old one is replaced.
      trust: execute the code of the run, which somebody else wrote.
    """

    source: Source
    terrains: int = TERRAINS
    seed: Seed = 0
    engine: EngineName | Literal["as-evolved"] = "as-evolved"
    roughness: OptionalFloat = None
    contact: OtherContactLaw = None
    json: OptionalFile = None
    trust: bool = False

    def run(self) -> int:
        """Compares, shows what came out, and returns the exit code.

        Raises:
          RunError: an argument is wrong, or the walker's body has what there is no second law for.
        """
        self._check()
        from mjxwalk import engines, walkers
        from mjxwalk.cli import verify_table
        from mjxwalk.verify import comparing

        engines.prepare()
        walker = walkers.best(self.source)
        try:
            agreement = comparing.verify(
                walker,
                engine=self._engine(),
                terrains=self.terrains,
                seed=self.seed,
                roughness=self.roughness,
                contact=self.contact,
                say=terminal.say,
            )
        except ValueError as error:
            raise RunError(str(error)) from None
        verify_table.show(agreement)
        if self.json is not None:
            outputs.write(self.json, outputs.as_json(agreement))
            terminal.say(f"wrote {self.json}")
        return 0 if agreement.agrees else DISAGREES

    def _check(self) -> None:
        """Finds wrong arguments that can be found without the second that importing JAX takes."""
        from mjxwalk import walkers

        if self.terrains < 1:
            raise RunError(f"--terrains must be at least 1, got {self.terrains}")
        budget.check_asked("--terrains", self.terrains)
        if self.roughness is not None and self.roughness < 0:
            raise RunError(f"--roughness must not be negative, got {self.roughness}")
        walkers.check(self.source, trust=self.trust)
        if self.json is not None:
            outputs.check(self.json, "--json")

    def _engine(self) -> str:
        """Returns the engine to compare with."""
        if self.engine != "as-evolved":
            return self.engine
        from mjxwalk import runs, walkers, zoo

        if walkers.in_zoo(self.source):
            return zoo.provenance(walkers.zoo_name(self.source)).engine
        return runs.load(self.source).manifest.get("engine", "auto")
