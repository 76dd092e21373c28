"""Which links a network has that begins with a share of all: drawn at random, the same for ever.

Erdős & Rényi (1959), "On random graphs I", Publicationes Mathematicae Debrecen 6: of all possible
links so many are there, every choice as likely as any other.
"""

import numpy as np
from jaxtyping import Bool

from mjxwalk.strategies.threefry import hash_words


def drawn(
    density: float, seed: int, number: int, kept: Bool[np.ndarray, "row column"]
) -> Bool[np.ndarray, "row column"]:
    """Returns which links of a matrix are there.

    Args:
      density: share of all its links, rounded.
      seed: of the choice.
      number: of the matrix, so that several of one seed are chosen independently.
      kept: links that are there in any case, and count.
    """
    places = np.arange(kept.size, dtype=np.uint32)
    # NumPy's generators may draw other numbers in a later version, which would change stored runs.
    key = (np.full(1, seed, np.uint32), np.full(1, number, np.uint32))
    chance, _ = hash_words(*key, places, np.zeros_like(places))
    first = np.lexsort((places, np.asarray(chance), ~kept.reshape(-1)))
    num = max(round(density * kept.size), int(kept.sum()))
    there = np.zeros(kept.size, bool)
    there[first[:num]] = True
    return there.reshape(kept.shape)
