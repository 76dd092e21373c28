"""What a published study is made of: phases, each an experiment that starts where one ended."""

import dataclasses
from typing import Any

from mjxwalk.experiments.scaling import scaled


@dataclasses.dataclass(frozen=True, kw_only=True)
class Study:
    """Experiments to be evolved one after the other.

    Attributes:
      name: as the command line knows it.
      phases: name of each and its `Experiment`, first to last; a phase that does not start from
        zero starts from the one before it.
    """

    name: str
    phases: tuple[tuple[str, Any], ...]

    def __post_init__(self) -> None:
        names = [name for name, _ in self.phases]
        if not names or len(set(names)) < len(names):
            raise ValueError(f"phases must have names of their own, got {', '.join(names)}")
        for name, experiment in self.phases:
            if experiment.name != f"{self.name}/{name}":
                raise ValueError(
                    f"the experiment of phase {name} must be named {self.name}/{name}, "
                    f"got {experiment.name}"
                )
        first = self.phases[0][1]
        if first.start != "zero":
            raise ValueError(f"{first.name} comes first and must start from zero")

    @classmethod
    def of(cls, name: str, *experiments: Any) -> "Study":
        """Returns the study of experiments that are named STUDY/PHASE, first to last."""
        return cls(
            name=name, phases=tuple((e.name.removeprefix(f"{name}/"), e) for e in experiments)
        )

    def phase(self, name: str) -> Any:
        """Returns a phase's experiment.

        Raises:
          KeyError: there is no such phase.
        """
        return dict(self.phases)[name]

    def scaled(self, factor: float) -> "Study":
        """Returns the study with populations and generations scaled, its structure kept."""
        phases = tuple((name, scaled(experiment, factor)) for name, experiment in self.phases)
        return dataclasses.replace(self, phases=phases)
