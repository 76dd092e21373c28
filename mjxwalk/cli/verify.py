"""The command `mjxwalk verify`."""

import dataclasses
from typing import TYPE_CHECKING, Any, Literal

from mjxwalk import budget, outputs, terminal
from mjxwalk.cli.argument_types import (
    TERRAINS,
    TRIALS,
    EngineName,
    OptionalFile,
    OptionalFloat,
    OtherContactLaw,
    Seed,
    Source,
    TerrainCount,
    TrialCount,
)
from mjxwalk.errors import RunError

if TYPE_CHECKING:
    from mjxwalk.walker import Walker

DISAGREES = 1  # exit code


@dataclasses.dataclass(frozen=True, kw_only=True)
class Verify:
    """Walk a run's best walker again in C MuJoCo, in float64, and compare with its engine.

    Kinematics, mass matrix and bias forces are C MuJoCo's; ground, joints, motors, senses and the
    rules of a trial are computed anew in float64, from code that shares nothing with the engine's.
    Shared are the body's XML, the settings, the terrains, the starts, and the controller's source,
    which JAX compiles for float64. The exit code is 0 if the two agree, 1 if they do not.

    A walker of one of Gymnasium's tasks plays episodes of gymnasium.make, and as many with its
    engine at the task's own settings; the two agree if their returns are of one distribution.

    Attributes:
      source: folder of a run, finished or not, or a walker that ships with mjxwalk.
      terrains: on which it walks, new to it.
      trials: of one of Gymnasium's tasks that it plays, in place of terrains.
      seed: of the terrains.
      engine: what to compare with; as-evolved is the one that evolved the walker.
      roughness: step of the random terrain, m.
      contact: law under which C MuJoCo walks, another than that of the engine: points, or mujoco
        for MuJoCo's own contacts.
      json: file to write the figures to; an old one is replaced.
      trust: execute the code of the run, which somebody else wrote.
    """

    source: Source
    terrains: TerrainCount = None
    trials: TrialCount = None
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
        from mjxwalk.cli import returns_table, verify_table
        from mjxwalk.envs.gymnasium import GymnasiumTask

        engines.prepare()
        walker = walkers.best(self.source)
        task = getattr(walker.experiment, "env", None)
        is_gymnasiums = isinstance(task, GymnasiumTask)
        self._check_flags(task.ID if isinstance(task, GymnasiumTask) else None)
        try:
            found = self._play(walker) if is_gymnasiums else self._compare(walker)
        except ValueError as error:
            raise RunError(str(error)) from None
        (returns_table if is_gymnasiums else verify_table).show(found)
        if self.json is not None:
            outputs.write(self.json, outputs.as_json(found))
            terminal.say(f"wrote {self.json}")
        return 0 if found.agrees else DISAGREES

    def _compare(self, walker: "Walker") -> Any:
        from mjxwalk.verify import comparing

        return comparing.verify(
            walker,
            engine=self._engine(),
            terrains=self.terrains or TERRAINS,
            seed=self.seed,
            roughness=self.roughness,
            contact=self.contact,
            say=terminal.say,
        )

    def _play(self, walker: "Walker") -> Any:
        from mjxwalk.verify import returns

        return returns.play(
            walker,
            engine=self._engine(),
            trials=self.trials or TRIALS,
            seed=self.seed,
            say=terminal.say,
        )

    def _check_flags(self, task: str | None) -> None:
        """Raises RunError for flags that say nothing of the walker's task.

        Args:
          task: of Gymnasium, None of another.
        """
        if task is None and self.trials is not None:
            raise RunError(
                f"--trials counts episodes of Gymnasium's tasks; {self.source} walks on terrains, "
                "which --terrains counts"
            )
        if task is None:
            return
        if self.terrains is not None:
            raise RunError(
                f"--terrains has no meaning for Gymnasium's {task}, whose ground is level; "
                "--trials counts its episodes"
            )
        if self.roughness is not None:
            raise RunError(
                f"--roughness has no meaning for Gymnasium's {task}, whose ground is level"
            )
        if self.contact is not None:
            raise RunError(
                f"--contact has no meaning for Gymnasium's {task}, whose contacts are MuJoCo's "
                "both here and in gymnasium"
            )

    def _check(self) -> None:
        """Finds wrong arguments that can be found without the second that importing JAX takes."""
        from mjxwalk import walkers

        for flag in ("terrains", "trials"):
            value = getattr(self, flag)
            if value is not None and value < 1:
                raise RunError(f"--{flag} must be at least 1, got {value}")
            budget.check_asked(f"--{flag}", value or 1)
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
