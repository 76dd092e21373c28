"""What the bench finds out, and its JSON."""

import dataclasses
from collections.abc import Mapping
from typing import Any

REFERENCE = "lanes"  # the engine whose speed is told as a multiple of the others'


@dataclasses.dataclass(frozen=True, kw_only=True)
class Kernel:
    """How the lanes engine computes a body.

    Attributes:
      operations_per_step: scalar operations, comparisons and selections included; of the control
        its share.
      share_of_peak: of the fused multiply-adds, two operations each, that the threads can do at
        this width, measured in turn; None where the operations are not counted, as of loops that
        may end early only the bodies are.
      width: lanes of a vector.
      threads: how many run.
      compile_cold_s: trace and compile in a fresh process with an empty disk cache, imports
        excluded, s.
      compile_warm_s: the same with the machine code on the disk, s.
      code_bytes: of the machine code.
    """

    operations_per_step: int
    share_of_peak: float | None
    width: int
    threads: int
    compile_cold_s: float
    compile_warm_s: float
    code_bytes: int


@dataclasses.dataclass(frozen=True, kw_only=True)
class Speed:
    """Of one body.

    Attributes:
      population: walkers at once, of our engines.
      steps_per_s: of all walkers together, for each contender; medians.
      ratios: how many times as fast the reference is as each other contender; medians of the
        ratios of timings that followed on each other.
      amounts: what a timing covers, for each contender: trials under MuJoCo's contacts, else steps.
      kernel: of the lanes engine.
      stopped: walkers of the lanes engine whose physics diverged, so that they did less work.
      contacts: active ones of a walker of C MuJoCo, on the average; None where it has none.
      warnings: of simulations of C MuJoCo that became unstable.
      left_out: contenders that were not measured, and why.
    """

    population: int
    steps_per_s: Mapping[str, float]
    ratios: Mapping[str, float]
    amounts: Mapping[str, int]
    kernel: Kernel
    stopped: int = 0
    contacts: float | None = None
    warnings: int = 0
    left_out: Mapping[str, str] = dataclasses.field(default_factory=dict[str, str])


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
      file_options: whether bodies under MuJoCo's contacts have the options of their files.
      speeds: by the name of the body.
      absent: bodies that could not be measured, and why.
      evolution: of the main body; None where it is not among those asked for.
      population_scaling: the same.
      versions: of the packages that matter; None where missing.
    """

    quick: bool
    file_options: bool = False
    repeats: int
    speeds: Mapping[str, Speed]
    absent: Mapping[str, str] = dataclasses.field(default_factory=dict[str, str])
    evolution: Evolution | None
    population_scaling: Scaling | None
    machine: Machine
    versions: Mapping[str, str | None]


def as_json(results: Results) -> dict[str, Any]:
    """Returns the results as JSON has them, derived figures included."""
    return {
        "quick": results.quick,
        "file_options": results.file_options,
        "repeats": results.repeats,
        "bodies": {body: _speed(speed) for body, speed in results.speeds.items()},
        "absent": dict(results.absent),
        "evolution": _evolution(results.evolution),
        "population_scaling": _scaling(results.population_scaling),
        "machine": dataclasses.asdict(results.machine),
        "versions": dict(results.versions),
    }


def _evolution(evolution: Evolution | None) -> dict[str, Any] | None:
    if evolution is None:
        return None
    return {**dataclasses.asdict(evolution), "share_of_peak": evolution.share_of_peak}


def _scaling(scaling: Scaling | None) -> dict[str, Any] | None:
    if scaling is None:
        return None
    return {
        **dataclasses.asdict(scaling),
        "ns_per_step": {str(size): cost for size, cost in scaling.ns_per_step.items()},
        "steps_per_walker": {str(size): n for size, n in scaling.steps_per_walker.items()},
        "spread": scaling.spread,
    }


def _speed(speed: Speed) -> dict[str, Any]:
    return {
        "population": speed.population,
        "steps_per_s": {**speed.steps_per_s, **dict.fromkeys(speed.left_out)},
        "ratios": {**speed.ratios, **dict.fromkeys(speed.left_out)},
        "amounts": dict(speed.amounts),
        "kernel": dataclasses.asdict(speed.kernel),
        "stopped": speed.stopped,
        "contacts": speed.contacts,
        "warnings": speed.warnings,
        "left_out": dict(speed.left_out),
    }
