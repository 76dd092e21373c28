"""The command `mjxwalk bench`."""

import dataclasses
import os
import time
from typing import Literal

import tyro

from mjxwalk import installing, outputs, terminal
from mjxwalk.bench import names
from mjxwalk.cli.argument_types import OptionalFile
from mjxwalk.errors import RunError


@dataclasses.dataclass(frozen=True, kw_only=True)
class Bench:
    """Measure engines, or strategies, against each other and against those of others.

    Attributes:
      subject: engines, against C MuJoCo and the CPU's peak; or strategies, against evosax and
        pycma.
      bodies: to measure the engines with, or "all"; `mjxwalk bench --bodies list` names them.
      file_options: integrate, and solve contacts, as the files of the bodies say. Without it bodies
        under MuJoCo's contacts have Euler's method, one iteration of Newton's and four of its line
        search, on both sides.
      quick: measure less, in a few minutes.
      xla: measure the engine lanes-xla also where JAX has only CPUs, for which it compiles slowly.
      json: file to write the numbers to; an old one is replaced.
    """

    subject: tyro.conf.Positional[Literal["engines", "strategies"]] = "engines"
    bodies: tuple[str, ...] = names.USUAL
    file_options: bool = False
    quick: bool = False
    xla: bool = False
    json: OptionalFile = None

    def run(self) -> int:
        """Measures, prints and returns the exit code.

        Raises:
          RunError: the file cannot be written, or there is no body of a name; found out before
            anything is measured.
        """
        if self.bodies == ("list",):
            for name, summary in names.BODIES.items():
                print(f"{name:<17} {summary}")
            return 0
        chosen = names.chosen(self.bodies)
        if self.json is not None:
            outputs.check(self.json, "--json")
        if self.subject == "strategies":
            return self._compare_strategies()
        from mjxwalk import engines
        from mjxwalk.engines import selection

        # A thread of XLA's that factorises matrices waits for a free one; where each of its devices
        # did so at once, as in `mjx.step` of a humanoid, all waited for ever.
        os.environ["NPROC"] = str(2 * selection.num_cores())
        engines.prepare()
        from mjxwalk.bench import measuring, results
        from mjxwalk.cli import bench_tables

        started = time.perf_counter()
        sizes = measuring.QUICK if self.quick else measuring.FULL
        sizes = dataclasses.replace(sizes, xla=self.xla, file_options=self.file_options)
        measured = measuring.measure(chosen, sizes, terminal.say)
        if self.json is not None:
            outputs.write(self.json, outputs.as_json(results.as_json(measured)))
        bench_tables.show(measured)
        wrote = "" if self.json is None else f", wrote {self.json}"
        terminal.say(f"took {time.perf_counter() - started:.0f} s{wrote}")
        return 0

    def _compare_strategies(self) -> int:
        from mjxwalk.bench import comparing

        try:
            numbers = comparing.measure_and_show(self.quick, terminal.say)
        except ImportError as error:
            raise RunError(
                f"comparing strategies needs evosax ({error}); add it with: "
                f"{installing.command('evosax')}"
            ) from None
        if self.json is not None:
            outputs.write(self.json, outputs.as_json(numbers))
        return 0
