"""The command `mjxwalk export`."""

import dataclasses
import math
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from mjxwalk import installing, outputs
from mjxwalk.cli.argument_types import OptionalFile, OptionalFloat, Seed, Source
from mjxwalk.errors import RunError

if TYPE_CHECKING:
    from mjxwalk.walker import Walker

MAX_SECONDS = 600.0  # ours: ten times the longest trial of an experiment
NAMES = {  # of files, where none is given
    "npz": "controller.npz",
    "safetensors": "controller.safetensors",
    "onnx": "controller.onnx",
    "mjcf": "body.xml",
    "sto": "trajectory.sto",
    "csv": "trajectory.csv",
}
CONTROLLERS = ("npz", "safetensors", "onnx")
TRAJECTORIES = ("sto", "csv")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Export:
    """Write a run's best walker for other programs: its controller, its body, or how it walks.

    A controller (npz, safetensors, onnx) gets a JSON file beside it, with inputs and outputs in
    their order, their units and scaling. The body is MJCF; a trajectory is OpenSim's .sto, or CSV.

    Attributes:
      source: folder of a run, finished or not, or a walker that ships with mjxwalk.
      to: what to write.
      out: the file, an old one is replaced; controller, body or trajectory in RUN, with the name
        before it where the walker ships.
      seconds: of a trajectory, after which it ends.
      frames_per_second: of a trajectory.
      terrain_seed: of a trajectory's random ground.
      roughness: of a trajectory's random ground, its step in m.
      trust: execute the code of the run, which somebody else wrote.
    """

    source: Source
    to: Literal["npz", "safetensors", "onnx", "mjcf", "sto", "csv"]
    out: OptionalFile = None
    seconds: float = 60.0
    frames_per_second: float = 100.0
    terrain_seed: Seed = 0
    roughness: OptionalFloat = None
    trust: bool = False

    def run(self) -> int:
        """Writes the files, says where, and returns the exit code.

        Raises:
          RunError: an argument is wrong, a package is missing, or there is no such walker.
        """
        self._check()
        out = self.out or self._default()
        self._check_out(out)
        from mjxwalk import engines, walkers
        from mjxwalk.fitting import Fitting

        engines.prepare()
        walker = walkers.best(self.source)
        if isinstance(walker.experiment, Fitting) or not hasattr(walker.experiment, "controller"):
            raise RunError(f"{self.source} is no walker with body and controller to export")
        self._check_told(walker.experiment)
        written = self._written(walker, out)
        run = None if self.out or walkers.in_zoo(self.source) else Path(self.source)
        for path, content in written.items():
            outputs.write(path, content, run=run)
            outputs.tell(path)
        return 0

    def _written(self, walker: "Walker", out: Path) -> dict[Path, bytes]:
        """Returns the files and what they hold."""
        from mjxwalk.export import body, controllers, sto, trajectory

        if self.to == "mjcf":
            return {out: body.as_mjcf(walker.experiment.env)}
        if self.to in TRAJECTORIES:
            take = trajectory.Take(
                seconds=self.seconds,
                frames_per_second=self.frames_per_second,
                terrain_seed=self.terrain_seed,
                roughness=self.roughness,
            )
            try:
                table = trajectory.record(walker, take)
            except ValueError as error:
                raise RunError(str(error)) from None
            return {out: sto.as_sto(table) if self.to == "sto" else sto.as_csv(table)}
        make = {
            "npz": controllers.as_npz,
            "safetensors": controllers.as_safetensors,
            "onnx": controllers.as_onnx,
        }[self.to]
        if outputs.is_stream(out):  # beside which no file belongs
            return {out: make(walker)}
        return {out: make(walker), out.with_suffix(".json"): controllers.told(walker)}

    def _check(self) -> None:
        """Finds wrong arguments that can be found without the second that importing JAX takes."""
        from mjxwalk import walkers

        if not (math.isfinite(self.seconds) and 0.1 <= self.seconds <= MAX_SECONDS):
            raise RunError(f"--seconds must be from 0.1 to {MAX_SECONDS:g}, got {self.seconds}")
        if not (math.isfinite(self.frames_per_second) and self.frames_per_second > 0):
            raise RunError(f"--frames-per-second must be above 0, got {self.frames_per_second}")
        if self.roughness is not None and self.roughness < 0:
            raise RunError(f"--roughness must not be negative, got {self.roughness}")
        walkers.check(self.source, trust=self.trust)
        if self.to == "onnx":
            installing.load("onnx", "onnx", "--to onnx")
        elif self.to == "safetensors":
            installing.load("safetensors", "export", "--to safetensors")

    def _check_told(self, experiment: object) -> None:
        """Raises RunError unless an experiment says what an export needs to know."""
        from mjxwalk import walkers
        from mjxwalk.export import step

        if self.to in CONTROLLERS:
            step.check(self.source, experiment)
        else:
            walkers.check_has_anatomy(self.source, experiment)

    def _default(self) -> Path:
        from mjxwalk import walkers

        if walkers.in_zoo(self.source):
            return Path(f"{walkers.zoo_name(self.source)}-{NAMES[self.to]}")
        return Path(self.source) / NAMES[self.to]

    def _check_out(self, out: Path) -> None:
        if self.to in CONTROLLERS and out.suffix == ".json":
            raise RunError(f"--out {out} would be replaced by the JSON file beside it")
        outputs.check(out)
        if self.to in CONTROLLERS and not outputs.is_stream(out):
            outputs.check(out.with_suffix(".json"))
