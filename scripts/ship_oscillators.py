"""Makes the champion of a `rayleigh-harmonic` run what drives `rayleigh-walk`."""

import dataclasses
import os
import sys

from mjxwalk import cli, outputs
from mjxwalk.cli.argument_types import OutPath, RunFolder

SETTLING_CYCLES = 100


@dataclasses.dataclass(frozen=True, kw_only=True)
class ShipOscillators:
    """Write the champion's genes, and where its oscillators are once settled, as a JSON file.

    Attributes:
      run_folder: of the run.
      out: file to write, if not that of this mjxwalk.
    """

    run_folder: RunFolder
    out: OutPath = None

    def run(self) -> int:
        """Writes the file and returns the exit code.

        Raises:
          RunError: the run has no champion, or the file cannot be written.
        """
        import msgspec
        import numpy as np

        from mjxwalk import runs, walkers
        from mjxwalk.analysis import fits
        from mjxwalk.controllers.rayleigh_walker import FITTED_PATH, Fitted
        from mjxwalk.experiments import repeating
        from mjxwalk.fitting import Fitting

        best = walkers.best(self.run_folder)
        if not isinstance(best.experiment, Fitting):
            raise runs.RunError(f"{self.run_folder} has no oscillators fitted to a gait")
        state = fits.settled_state(best.experiment, best.genotype, SETTLING_CYCLES)
        fitted = Fitted(
            command=repeating.command(runs.load(self.run_folder), best.experiment),
            genes={
                name: np.asarray(value).tolist() for name, value in best.genotype._asdict().items()
            },
            angle=np.asarray(state.angle).tolist(),
            rate=np.asarray(state.rate).tolist(),
        )
        path = self.out or FITTED_PATH
        text = msgspec.json.format(msgspec.json.encode(fitted), indent=1)
        outputs.write(path, text + b"\n")
        outputs.tell(path)
        return 0


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # a few numbers; leave the GPU to its owner
    sys.exit(cli.run("ship_oscillators.py", ShipOscillators))
