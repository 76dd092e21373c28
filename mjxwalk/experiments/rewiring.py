"""How networks are rewired: the numbers of `strategies.with_rewiring`, as settings."""

import dataclasses

from mjxwalk.envs.checks import positive


@dataclasses.dataclass(frozen=True, kw_only=True)
class Rewiring:
    """The weakest links of each layer go, and others grow once few are left.

    Mocanu et al. (2018), sparse evolutionary training, gives the share that goes.

    Attributes:
      every: generations from one rewiring to the next.
      fraction: share of the links that are there that goes, those whose weights are nearest to 0.
      density: share of all links of a layer to which others grow again, at random; the network
        begins with all links and gets there step by step.
    """

    every: int = 10
    fraction: float = 0.3
    density: float = 0.2

    def __post_init__(self) -> None:
        positive(self, "every")
        for name in ("fraction", "density"):
            if not 0 < getattr(self, name) <= 1:
                raise ValueError(f"{name} must be above 0 and at most 1, got {getattr(self, name)}")
