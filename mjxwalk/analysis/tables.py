"""The paper's tables from our runs, its surviving numbers beside ours.

Solomon, Locascio & Hartmann (2013), Adaptive Behavior 21(1), doi 10.1177/1059712312462904, sections
3.2 to 3.4. Columns have plain names and plain numbers, so that a table is also its CSV; NaN is what
nobody knows. Table 3 itself is `links.survival_table`.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool

from mjxwalk.analysis import links, paper
from mjxwalk.analysis.frame import Frame
from mjxwalk.analysis.gait import FIGURES, Gait, across, spread
from mjxwalk.analysis.intervals import wilson
from mjxwalk.controllers.linear_reactive import NETWORKS
from mjxwalk.strategies.links import SURVIVAL_THRESHOLD


class Benchmark(NamedTuple):
    """How one winner does, from a tournament or from recorded trials.

    Attributes:
      trials: each on a new terrain.
      falls: trials that ended by one.
      cost_of_transport: None of a walker that did not get forward.
    """

    trials: int
    falls: int
    cost_of_transport: float | None


def table_3_summary(
    present: Bool[np.ndarray, "run network input"], *, threshold: float = SURVIVAL_THRESHOLD
) -> Frame:
    """Returns, by network, the share of non-local links kept, and how many the reduced set has.

    Args:
      present: links of the winner of each run, from `links.presence`.
      threshold: share of the runs in which a link of the reduced set is left.
    """
    import pandas as pd

    reduced = links.reduced(present, threshold=threshold)
    left = links.as_setting(reduced)
    return pd.DataFrame(
        {
            "kept": links.retention(present),
            "paper_kept": [paper.RETENTION[network] for network in NETWORKS],
            "reduced_links": [len(left.get(network, ())) for network in NETWORKS],
            "paper_reduced_links": [paper.REDUCED[network] for network in NETWORKS],
        },
        index=pd.Index(NETWORKS, name="network"),
    )


def table_4(winners: Mapping[str, Sequence[Benchmark]]) -> Frame:
    """Returns falls and cost of transport, a row for each variant, with the paper's.

    The interval of the fall rate is Wilson's of 95 % over the trials of all winners together: it
    tells how well these winners are known, not how far winners differ.

    Args:
      winners: of each variant, such as "lpd"; the paper's numbers stand beside those it has.
    """
    import pandas as pd

    rows: dict[str, dict[str, float]] = {}
    for variant, benchmarks in winners.items():
        trials = sum(each.trials for each in benchmarks)
        falls = sum(each.falls for each in benchmarks)
        rates = [each.falls / each.trials for each in benchmarks if each.trials]
        low, high = wilson(falls, trials) if trials else (np.nan, np.nan)
        cost = spread(
            np.array(
                [np.nan if (c := each.cost_of_transport) is None else c for each in benchmarks],
                np.float64,
            )
        )
        rows[variant] = {
            "runs": len(benchmarks),
            "trials": trials,
            "fall_rate": falls / trials if trials else np.nan,
            "fall_rate_low": low,
            "fall_rate_high": high,
            "lowest_fall_rate": min(rates, default=np.nan),
            "paper_lowest_fall_rate": _value(paper.FALL_RATE.get(variant)),
            "cost_of_transport": cost.mean,
            "cost_of_transport_sd": cost.sd,
            "paper_cost_of_transport": _value(paper.COST_OF_TRANSPORT.get(variant)),
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("variant")


def table_5(winners: Mapping[str, Sequence[Gait]]) -> Frame:
    """Returns means and deviations of the gaits, a row for each variant, and a human's.

    Deviations are between winners as in the paper; of one winner alone, between its trials.

    Args:
      winners: of each variant; NaN where no trial went without a fall.
    """
    import pandas as pd

    rows: dict[str, dict[str, float]] = {}
    for variant, gaits in winners.items():
        gait = gaits[0] if len(gaits) == 1 else across(gaits)
        rows[variant] = {
            "runs": len(gaits),
            "trials": gait.trials,
            "falls": gait.falls,
            "strides": gait.strides,
        }
        for name in FIGURES:
            rows[variant][name] = getattr(gait, name).mean
            rows[variant][f"{name}_sd"] = getattr(gait, name).sd
    for row, source in (("human", paper.HUMAN), ("human, as in the paper", paper.HUMAN_IN_PAPER)):
        rows[row] = {name: _value(quoted) for name, quoted in source.items()}
        rows[row] |= {f"{name}_sd": _sd(quoted) for name, quoted in source.items()}
    table = pd.DataFrame.from_dict(rows, orient="index").rename_axis("variant")
    # Whole numbers stay whole beside a human's, which are missing.
    whole = ("runs", "trials", "falls", "strides") if winners else ()
    return table.astype(dict.fromkeys(whole, "Int64"))


def _value(quoted: paper.Quoted | None) -> float:
    return np.nan if quoted is None or quoted.value is None else quoted.value


def _sd(quoted: paper.Quoted) -> float:
    return np.nan if quoted.sd is None else quoted.sd
