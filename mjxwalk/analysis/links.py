"""Which links pruning leaves: Table 3, and the reduced set of links that is made from it.

Solomon, Locascio & Hartmann (2013), Adaptive Behavior 21(1), doi 10.1177/1059712312462904, sections
2.7.5 and 3.2. A removed link is a weight of exactly zero, in both of a controller's weight sets, so
that links are read off genotypes.
"""

from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mjxwalk.analysis.frame import Frame
from mjxwalk.controllers.linear_reactive import INPUTS, NETWORKS, local_links
from mjxwalk.strategies.links import SURVIVAL_THRESHOLD, reduce_links, survival


def presence(genotypes: Sequence[Any]) -> Bool[np.ndarray, "run network input"]:
    """Returns which links each genotype has.

    Args:
      genotypes: of `LinearReactive`, one a run.
    """
    present = [np.asarray(g.initiation != 0) | np.asarray(g.walking != 0) for g in genotypes]
    return np.stack(present)


def survivors(present: Bool[np.ndarray, "run network input"]) -> Int[np.ndarray, "network input"]:
    """Returns in how many runs each link is left."""
    return np.asarray(survival(jnp.asarray(present)))


def retention(present: Bool[np.ndarray, "run network input"]) -> Float[np.ndarray, " network"]:
    """Returns the share of its non-local links that each network keeps, on average over the runs.

    Section 3.2's 61, 51, 66, 8, 18 and 32 % are these.
    """
    free = ~local_links()
    return np.array([present[:, row, free[row]].mean() for row in range(len(NETWORKS))])


def reduced(
    present: Bool[np.ndarray, "run network input"], *, threshold: float = SURVIVAL_THRESHOLD
) -> Bool[np.ndarray, "network input"]:
    """Returns the links that are left in at least a share of the runs, and the local ones."""
    counts = jnp.asarray(survivors(present))
    mask = reduce_links(counts, len(present), threshold=threshold)
    return np.asarray(mask) | local_links()


def as_setting(mask: Bool[np.ndarray, "network input"]) -> dict[str, tuple[str, ...]]:
    """Returns the non-local links of a mask as `LinearReactive` takes them: inputs by network."""
    free = mask & ~local_links()
    return {
        network: tuple(name for name, there in zip(INPUTS, row, strict=True) if there)
        for network, row in zip(NETWORKS, free, strict=True)
        if row.any()
    }


def survival_table(present: Bool[np.ndarray, "run network input"]) -> Frame:
    """Returns Table 3: in how many runs each link is left, inputs down, networks across.

    Local links, which are never removed, are counted too: their number is that of the runs.
    """
    import pandas as pd

    return pd.DataFrame(survivors(present).T, index=list(INPUTS), columns=list(NETWORKS))
