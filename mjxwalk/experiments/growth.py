"""How a population grows within a generation: the numbers of `mjxwalk.evolution.growing`."""

import dataclasses

from mjxwalk.envs.checks import positive

# Their state is one distribution, whatever number of genotypes is drawn from it or told.
STRATEGIES = ("pgpe", "openai-es")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Growth:
    """A generation is evaluated part by part until its walkers have done enough steps together.

    Toklu, Liskowski & Srivastava (2020), "ClipUp", https://arxiv.org/abs/2008.02387: while walkers
    fall early a generation has many of them, and few once they walk. The defaults are those of
    train_walker2d.sh of nnaisense/pgpelib, with a population of at most 800.

    Attributes:
      part: genotypes that are evaluated at a time, in pairs of mirrored noise; even, and a divisor
        of the population's size, which is the most that a generation can have.
      interactions: environment steps, summed over all trials of the generation, after which no
        further part is evaluated.
    """

    part: int = 100
    interactions: int = 75_000

    def __post_init__(self) -> None:
        positive(self, "part", "interactions")
        if self.part % 2:
            raise ValueError(f"part must be even, as noise is mirrored, got {self.part}")

    def check(self, strategy: str, population_size: int) -> None:
        """Raises ValueError unless a strategy of that name can grow to that population."""
        if strategy not in STRATEGIES:
            raise ValueError(
                f"growth is for the strategies {' and '.join(STRATEGIES)}, whose state does not "
                f"depend on the number of genotypes, got {strategy}; set growth to null"
            )
        if population_size % self.part:
            raise ValueError(
                f"population_size must be a multiple of growth.part, {self.part}, got "
                f"{population_size}"
            )
