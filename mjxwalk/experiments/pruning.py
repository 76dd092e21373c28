"""How links are pruned: the numbers of `strategies.with_pruning`, as settings."""

import dataclasses

from mjxwalk.envs.checks import not_negative, positive


@dataclasses.dataclass(frozen=True, kw_only=True)
class Pruning:
    """Links go one by one until the walkers get worse.

    Solomon et al. (2013), section 2.7.3, gives all defaults.

    Attributes:
      every: generations from one removal to the next.
      floor: pruning ends when elites' median fitness is below this share of what it was before.
      reference: last generations before pruning whose elites say what it was.
      window: latest generations whose elites are compared with it.
      settle: generations without pruning after its end.
    """

    every: int = 10
    floor: float = 0.9
    reference: int = 50
    window: int = 10
    settle: int = 200

    def __post_init__(self) -> None:
        positive(self, "every", "reference", "window")
        not_negative(self, "settle")
        if self.window > self.reference:
            raise ValueError(
                f"window must be at most reference, {self.reference}, got {self.window}"
            )
        if not 0 < self.floor <= 1:
            raise ValueError(f"floor must be above 0 and at most 1, got {self.floor}")
