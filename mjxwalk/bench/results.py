"""What the bench finds out, and its JSON."""

import dataclasses
from collections.abc import Mapping
from typing import Any

REFERENCE = "lanes"  # the engine whose speed is told as a multiple of the others'


@dataclasses.dataclass(frozen=True, kw_only=True)
class Speed:
    """Of one body.

    Attributes:
      population: walkers at once.
      operations_per_step: scalar operations of the lanes engine.
      steps_per_s: of all walkers together, for each contender.
      steps_per_walker: that a timing covers, for each contender.
      left_out: contenders that were not measured, and why.
    """

    population: int
    operations_per_step: int
    steps_per_s: Mapping[str, float]
    steps_per_walker: Mapping[str, int]
    left_out: Mapping[str, str] = dataclasses.field(default_factory=dict[str, str])

    def ratio(self, name: str) -> float:
        """Returns how many times as fast as a contender the reference engine is."""
        return self.steps_per_s[REFERENCE] / self.steps_per_s[name]

    @property
    def others(self) -> list[str]:
        """All contenders but the reference."""
        return [name for name in self.steps_per_s if name != REFERENCE]


@dataclasses.dataclass(frozen=True, kw_only=True)
class CompileSeconds:
    """Trace and compile of the planar rollout in a fresh process, imports excluded.

    Attributes:
      cold: with an empty disk cache, s.
      warm: from the disk cache, s.
    """

    cold: float
    warm: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Evolution:
    """Trials of populations that evolve, where walkers fall at different times.

    Attributes:
      generations: that they evolve for; the trials of all are timed.
      population: trials at once.
      lane_utilisation: share of lane-steps that moved a walker.
      steps_per_s: of all walkers together.
      peak_steps_per_s: where all walkers take the same number of steps, measured in turn with it.
    """

    generations: int
    population: int
    lane_utilisation: float
    steps_per_s: float
    peak_steps_per_s: float

    @property
    def share_of_peak(self) -> float:
        """Of the steps/s, between 0 and 1."""
        return self.steps_per_s / self.peak_steps_per_s


@dataclasses.dataclass(frozen=True, kw_only=True)
class Scaling:
    """Cost of a step by population size.

    Attributes:
      ns_per_step: of wall clock a walker-step, for each population.
      steps_per_walker: that a timing covers, for each population.
      peak_memory_bytes: of a process that runs the largest population.
      memory_before_bytes: its peak before that, with the kernel loaded.
    """

    ns_per_step: Mapping[int, float]
    steps_per_walker: Mapping[int, int]
    peak_memory_bytes: int
    memory_before_bytes: int

    @property
    def spread(self) -> float:
        """How much dearer than the cheapest the dearest is: 0.15 is 15 %."""
        return max(self.ns_per_step.values()) / min(self.ns_per_step.values()) - 1.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Arithmetic:
    """How near the lanes engine comes to what the vector units can do.

    Attributes:
      operations_per_step: scalar operations, comparisons and selections included.
      steps_per_s: of all walkers together.
      peak_gflops: of fused multiply-adds, two operations each, at this width on these threads.
      width: lanes of a vector.
      threads: how many run.
    """

    operations_per_step: int
    steps_per_s: float
    peak_gflops: float
    width: int
    threads: int

    @property
    def gflops(self) -> float:
        """Operations a second reached, in billions."""
        return 1e-9 * self.operations_per_step * self.steps_per_s

    @property
    def share_of_peak(self) -> float:
        """Of the arithmetic peak, between 0 and 1."""
        return self.gflops / self.peak_gflops


@dataclasses.dataclass(frozen=True, kw_only=True)
class Machine:
    """Where it was measured.

    Attributes:
      cpu: the processor's name.
      cores: of the machine.
      usable_cores: that this process may use.
      load_average: over the last minute before the bench; None where the system does not tell.
      mjx_devices: what the mjx engine ran on, in words.
      accelerator: whether those are no CPU.
    """

    cpu: str
    cores: int
    usable_cores: int
    load_average: float | None
    mjx_devices: str
    accelerator: bool


@dataclasses.dataclass(frozen=True, kw_only=True)
class Results:
    """Everything.

    Attributes:
      quick: whether less was measured.
      speeds: by the name of the body.
      arithmetic: of the planar body.
      versions: of the packages that matter; None where missing.
    """

    quick: bool
    repeats: int
    speeds: Mapping[str, Speed]
    compile_s: CompileSeconds
    evolution: Evolution
    population_scaling: Scaling
    arithmetic: Arithmetic
    machine: Machine
    versions: Mapping[str, str | None]


def as_json(results: Results) -> dict[str, Any]:
    """Returns the results as JSON has them, derived figures included."""
    scaling = results.population_scaling
    return {
        "quick": results.quick,
        "repeats": results.repeats,
        **{body: _speed(speed) for body, speed in results.speeds.items()},
        "compile_s": dataclasses.asdict(results.compile_s),
        "lane_utilisation": results.evolution.lane_utilisation,
        "evolution": {
            **dataclasses.asdict(results.evolution),
            "share_of_peak": results.evolution.share_of_peak,
        },
        "population_scaling": {
            **dataclasses.asdict(scaling),
            "ns_per_step": {str(size): cost for size, cost in scaling.ns_per_step.items()},
            "steps_per_walker": {str(size): n for size, n in scaling.steps_per_walker.items()},
            "spread": scaling.spread,
        },
        "arithmetic": {
            **dataclasses.asdict(results.arithmetic),
            "gflops": results.arithmetic.gflops,
            "share_of_peak": results.arithmetic.share_of_peak,
        },
        "machine": dataclasses.asdict(results.machine),
        "versions": dict(results.versions),
    }


def _speed(speed: Speed) -> dict[str, Any]:
    return {
        "population": speed.population,
        "operations_per_step": speed.operations_per_step,
        **speed.steps_per_s,
        **{f"{REFERENCE}_over_{name}": speed.ratio(name) for name in speed.others},
        **dict.fromkeys(speed.left_out),
        **{f"{REFERENCE}_over_{name}": None for name in speed.left_out},
        "steps_per_walker": dict(speed.steps_per_walker),
        "left_out": dict(speed.left_out),
    }
