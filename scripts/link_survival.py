"""Shows which links are left in the best walkers of several runs, and what most of them keep."""

import dataclasses
import json
import os
import sys
from pathlib import Path
from typing import Annotated, Any

import tyro

from mjxwalk import cli, outputs, runs, walkers
from mjxwalk.analysis import style

Sources = tyro.conf.Positional[
    Annotated[tuple[str, ...], tyro.conf.arg(metavar="RUN|zoo:NAME ...")]
]


@dataclasses.dataclass(frozen=True, kw_only=True)
class LinkSurvival:
    """Count the links that are left after pruning, by network and input, over runs.

    Attributes:
      sources: folders of pruned runs, or walkers that ship with mjxwalk.
      threshold: share of the runs in which a link of the reduced set is left.
      csv: file to write the counts to.
      figure: file to draw the counts into; its ending says which kind.
      reduced: JSON file to write the reduced set to, for `mjxwalk evolve --links`.
    """

    sources: Sources
    threshold: float = 0.8
    csv: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    figure: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    reduced: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None

    @style.own()
    def run(self) -> int:
        """Prints the tables, writes what was asked for, and returns the exit code.

        Raises:
          RunError: there is no such source, it has no links, or a file cannot be written.
        """
        if not self.sources:
            raise runs.RunError("no runs were named")
        if not 0.0 < self.threshold <= 1.0:
            raise runs.RunError(f"--threshold must be above 0 and at most 1, got {self.threshold}")
        for source in self.sources:
            walkers.check(source)
        for flag in ("csv", "figure", "reduced"):
            if getattr(self, flag) is not None:
                outputs.check(getattr(self, flag), f"--{flag}")
        from mjxwalk.analysis import links, tables

        present = links.presence([_linked(source) for source in self.sources])
        counts = links.survival_table(present)
        mask = links.reduced(present, threshold=self.threshold)
        print(f"links left, of {len(self.sources)} runs:")
        print(counts.to_string())
        print(f"\nnon-local links kept, and left at a threshold of {self.threshold:g}:")
        print(tables.table_3_summary(present, threshold=self.threshold).round(2).to_string())
        self._write(counts, mask)
        return 0

    def _write(self, counts: Any, mask: Any) -> None:
        from mjxwalk.analysis import links

        if self.csv is not None:
            outputs.write_text(self.csv, counts.to_csv(index_label="input"))
        if self.reduced is not None:
            text = json.dumps(links.as_setting(mask), indent=2) + "\n"
            outputs.write_text(self.reduced, text)
        if self.figure is not None:
            from mjxwalk.analysis import figures

            figure = figures.link_survival(counts, len(self.sources), mask)
            outputs.write_figure(self.figure, figure, dpi=150)
        for path in (self.csv, self.reduced, self.figure):
            if path is not None:
                outputs.tell(path)


def _linked(source: str) -> Any:
    """Returns the genotype of a source's best walker."""
    genotype = walkers.best(source).genotype
    if not hasattr(genotype, "walking"):
        raise runs.RunError(f"{source} holds walkers without links to count")
    return genotype


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # a few numbers; leave the GPU to its owner
    sys.exit(cli.run("link_survival.py", LinkSurvival))
