"""Counts the machine instructions of a step in the kernels of lanes, by what they do.

The peak of `mjxwalk bench` is that of multiply-adds, two operations an instruction. What does not
fuse takes an instruction for one operation, which sets a bound on the share of that peak: printed
here beside the counts. Counts are of the longest block of the kernel, that of a step. x86 only.
"""

import collections
import dataclasses
import re
import sys
from typing import Annotated, Any, Literal

import tyro

from mjxwalk import cli, experiments, terminal
from mjxwalk.errors import RunError, near

FUSED, OTHER, CHOICE = "multiply-add", "other arithmetic", "comparison, choice"
KINDS = {  # by what an instruction's name begins with; the first that fits
    FUSED: r"vfn?m(add|sub)",
    OTHER: r"v(add|sub|mul|min|max|div|sqrt|rcp|rsqrt|round|rndscale|cvt)",
    CHOICE: r"v(cmp|blend|ptest|pternlog|and|or|xor|pand|por|pxor|pcmp|mask)|k(and|or)",
    "constant from memory": r"vbroadcast|vpbroadcast",
    "load, store, move": r"v?mov|vpmov|vmovaps|vmovups|kmov",
    "integer": r"vp",
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class InstructionMix:
    """Count the machine instructions of a step by what they do.

    Attributes:
      experiment: whose rollout it is.
      width: lanes of a vector; that of this CPU by default, 8 for AVX2.
    """

    experiment: tyro.conf.Positional[Annotated[str, tyro.conf.arg(metavar="NAME")]] = "planar-lpd"
    width: Literal[4, 8, 16] | None = None

    def run(self) -> int:
        """Prints the table and returns the exit code.

        Raises:
          RunError: there is no such experiment.
        """
        if self.experiment not in experiments.names():
            raise RunError(
                f"no experiment {self.experiment!r}{near(self.experiment, experiments.names())}"
            )
        block = self._block()
        counts = collections.Counter(
            map(kind_of, re.findall(r"^\t([a-z]\w*)", block, re.MULTILINE))
        )
        total = sum(counts.values())
        for kind, count in counts.most_common():
            terminal.say(f"{count:6,}  {count / total:4.0%}  {kind}")
        terminal.say(f"{total:6,}        in all")
        slots = counts[FUSED] + counts[OTHER] + counts[CHOICE]
        operations = slots + counts[FUSED]
        terminal.say(
            f"{operations:,} operations in {slots:,} instructions that compute: "
            f"at most {operations / (2 * slots):.0%} of the peak"
        )
        return 0

    def _block(self) -> str:
        import jax

        from mjxwalk import engines
        from mjxwalk.engines.lanes.explain import explain

        engines.prepare()
        experiment: Any = experiments.get(self.experiment)
        given = experiment.sample_trials(jax.random.key(0), 1).given(0)
        return explain(experiment.rollout, experiment.template(), given, width=self.width).assembly


def kind_of(instruction: str) -> str:
    """Returns what an instruction of x86 does."""
    for kind, pattern in KINDS.items():
        if re.match(pattern, instruction):
            return kind
    return "scalar: addresses, jumps"


if __name__ == "__main__":
    sys.exit(cli.run("instruction_mix.py", InstructionMix))
