"""What a population takes of the machine's memory, found out before it is taken."""

import math
import os
from typing import Any

import jax

from mjxwalk.runs import RunError


def check(arrays: Any) -> None:
    """Returns if arrays fit into this machine's memory.

    XLA ends the process where they do not, and the system does where they do so barely.

    Args:
      arrays: anything with their shapes and types.

    Raises:
      RunError: they do not.
    """
    # One at a time of these is enough to be sure; how many more there are depends on the strategy.
    needed = sum(math.prod(leaf.shape) * leaf.dtype.itemsize for leaf in jax.tree.leaves(arrays))
    available = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if needed > available:
        raise RunError(
            f"the population and its strategy take {needed / 1e9:.3g} GB, and this machine has "
            f"{available / 1e9:.3g} GB of memory; set a smaller --population"
        )
