"""Runs all measurements, one after the other."""

import dataclasses
import os
import platform
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import jax

import mjxwalk
from mjxwalk.bench import bodies, child, contenders, timing
from mjxwalk.bench.bodies import Body, PointBody
from mjxwalk.bench.evolved import Evolved
from mjxwalk.bench.names import MAIN
from mjxwalk.bench.peak import Peak
from mjxwalk.bench.results import (
    REFERENCE,
    Evolution,
    Kernel,
    Machine,
    Results,
    Scaling,
    Speed,
)
from mjxwalk.engines import lanes
from mjxwalk.engines.lanes.runtime.thread_pool import num_threads
from mjxwalk.engines.selection import num_cores
from mjxwalk.errors import RunError
from mjxwalk.runs import manifest

PEAK = "peak"
SLOW = ("flame-points", "flame", "humanoid", "humanoid-ground", "h1", "h1-points")  # to compile
TOO_SLOW = "XLA compiles it for some 20 s or more, run without --quick"
Say = Callable[[str], None]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sizes:
    """How much is measured.

    Attributes:
      quick: whether this is less than usual.
      population: walkers at once where engines are compared.
      seconds: that a timing should take.
      repeats: timings that a median is of.
      generations: of the evolution.
      populations: whose cost a step is compared, smallest first.
      shortest: steps a walker takes at least, where populations are compared.
      xla: whether lanes-xla is measured also where JAX has no accelerator.
      file_options: whether bodies under MuJoCo's contacts have the options of their files.
    """

    quick: bool
    population: int
    seconds: float
    repeats: int
    generations: int
    populations: tuple[int, ...]
    shortest: int
    xla: bool = False
    file_options: bool = False


FULL = Sizes(
    quick=False,
    population=1024,
    seconds=0.4,
    repeats=9,
    generations=60,
    populations=(64, 1024, 65_536),
    shortest=1000,
)
QUICK = Sizes(
    quick=True,
    population=1024,
    seconds=0.15,
    repeats=5,
    generations=20,
    populations=(64, 1024, 8192),
    shortest=500,
)


def measure(names: Sequence[str], sizes: Sizes, say: Say) -> Results:
    """Returns what was measured.

    Args:
      names: of the bodies.
      sizes: how much.
      say: is told what is being measured.

    Raises:
      RunError: no body is there, as the package that it comes with is not installed.
    """
    machine = _machine()
    found, absent = _found(names, sizes.file_options)
    evolved: Any = None
    if MAIN in found:
        say("compiling, and evolving what is to be timed")
        evolved = Evolved(_main().study(), sizes.generations)
    speeds: dict[str, Speed] = {}
    for name, body in found.items():
        say(f"measuring {name}")
        speeds[name] = speed(name, body, sizes, machine.accelerator)
    evolution, scaling = None, None
    if MAIN in found:
        say(f"measuring trials of populations as they evolve, {sizes.generations} generations")
        evolution = evolve(_main(), evolved, sizes)
        say("measuring populations from small to large")
        scaling = scale(_main(), sizes)
    return Results(
        quick=sizes.quick,
        file_options=sizes.file_options,
        repeats=sizes.repeats,
        speeds=speeds,
        absent=absent,
        evolution=evolution,
        population_scaling=scaling,
        machine=machine,
        versions=_versions(),
    )


def _main() -> PointBody:
    body = bodies.get(MAIN)
    assert isinstance(body, PointBody)
    return body


def _found(names: Sequence[str], file_options: bool) -> tuple[dict[str, Body], dict[str, str]]:
    """Returns the bodies by name, and those that are not there, and why."""
    found: dict[str, Body] = {}
    absent: dict[str, str] = {}
    for name in names:
        try:
            found[name] = bodies.get(name, file_options=file_options)
        except ValueError as error:
            absent[name] = str(error)
    if not found:
        raise RunError("; ".join(dict.fromkeys(absent.values())))
    return found, absent


def speed(name: str, body: Body, sizes: Sizes, accelerator: bool) -> Speed:
    """Returns how fast the contenders are with one body, in turn with the CPU's peak.

    XLA compiles in a thread of its own, while other processes compile for lanes and are timed.
    """
    slow = name in SLOW and sizes.quick and not accelerator
    left_out = {"mjx": TOO_SLOW} if slow else {}
    cost = child.compiling(name, file_options=sizes.file_options)
    rivals = contenders.make(
        body, sizes.population, num_threads(), xla=sizes.xla or accelerator, without=left_out
    )
    _compile(rivals)
    seen = rivals["mujoco_batch"].observe() if _touches(body) else None
    timings, amounts = _timings({**rivals, PEAK: Peak(num_threads())}, sizes)
    rates = {rival: timing.rate(taken) for rival, taken in timings.items()}
    return Speed(
        population=sizes.population,
        steps_per_s={rival: rates[rival] for rival in rivals},
        ratios={
            rival: timing.ratio(timings[REFERENCE], timings[rival])
            for rival in rivals
            if rival != REFERENCE
        },
        amounts={rival: amounts[rival] for rival in rivals},
        kernel=_kernel(body, rivals, cost, timing.ratio(timings[REFERENCE], timings[PEAK])),
        stopped=bodies.num_stopped(_engine(rivals[REFERENCE]).walked),
        contacts=None if seen is None else seen.contacts,
        warnings=0 if seen is None else seen.warnings,
        left_out=left_out,
    )


def _touches(body: Body) -> bool:
    """Returns whether C MuJoCo has contacts."""
    return not isinstance(body, PointBody) or body.peer is not None


def _compile(rivals: Mapping[str, Any]) -> None:
    """Lets all contenders do a little, so that what they compile is compiled."""
    with ThreadPoolExecutor(1) as other:
        by_xla = [rival for rival in ("mjx", "lanes_xla") if rival in rivals]
        compiling: list[Future[int]] = [other.submit(rivals[rival], 1) for rival in by_xla]
        for rival in rivals:
            if rival not in by_xla:
                rivals[rival](1)
        for compiled in compiling:
            compiled.result()


def _timings(
    field: Mapping[str, Any], sizes: Sizes
) -> tuple[dict[str, list[timing.Timing]], dict[str, int]]:
    """Returns each contender's timings, taken in turn, and what one of them covers."""
    amounts = {name: timing.calibrate(one, sizes.seconds) for name, one in field.items()}
    return timing.in_turn(field, amounts, sizes.repeats), amounts


def _engine(contender: Any) -> Any:
    """Returns the engine of a contender of ours."""
    return getattr(contender, "engine", contender)


def _kernel(body: Body, rivals: Mapping[str, Any], cost: child.Compiling, of_peak: float) -> Kernel:
    """Returns how the lanes engine computes a body.

    Args:
      of_peak: steps of the body for each operation that the CPU could have done meanwhile.
    """
    mapped = _engine(rivals[REFERENCE]).mapped
    linear = _engine(rivals.get(contenders.LINEAR, rivals[REFERENCE])).mapped
    operations, is_counted = linear.compiled.operations, True
    if not isinstance(body, PointBody):
        operations, is_counted = body.operations(operations), body.is_straight
    return Kernel(
        operations_per_step=operations,
        share_of_peak=operations * of_peak if is_counted else None,
        width=mapped.compiled.target.width,
        threads=mapped.threads,
        compile_cold_s=cost.cold,
        compile_warm_s=cost.warm,
        code_bytes=cost.code_bytes,
    )


def evolve(body: PointBody, evolved: Any, sizes: Sizes) -> Evolution:
    """Returns how fast populations that evolve run, in turn with one where nobody falls early."""
    level = contenders.Engine(lanes.vmap, body.workload(evolved.size))
    field = {"evolved": evolved, PEAK: level}
    amounts = {name: timing.calibrate(one, sizes.seconds) for name, one in field.items()}
    timings = timing.in_turn(field, amounts, sizes.repeats)
    return Evolution(
        generations=sizes.generations,
        population=evolved.size,
        lane_utilisation=evolved.lane_utilisation,
        steps_per_s=timing.rate(timings["evolved"]),
        peak_steps_per_s=timing.rate(timings[PEAK]),
    )


def scale(body: PointBody, sizes: Sizes) -> Scaling:
    """Returns what a step costs in small and large populations."""
    field = {
        str(size): contenders.Engine(lanes.vmap, body.workload(size)) for size in sizes.populations
    }
    amounts = {
        name: max(sizes.shortest, timing.calibrate(one, sizes.seconds))
        for name, one in field.items()
    }
    timings = timing.in_turn(field, amounts, sizes.repeats)
    memory = child.peak_memory(MAIN, sizes.populations[-1])
    return Scaling(
        ns_per_step={int(name): 1e9 / timing.rate(timings[name]) for name in field},
        steps_per_walker={int(name): amount for name, amount in amounts.items()},
        peak_memory_bytes=memory["after"],
        memory_before_bytes=memory["before"],
    )


def _machine() -> Machine:
    devices = jax.devices()
    return Machine(
        cpu=manifest.cpu_model(),
        cores=os.cpu_count() or 1,
        usable_cores=num_cores(),
        load_average=os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        mjx_devices=f"{len(devices)} x {devices[0].device_kind}",
        accelerator=devices[0].platform != "cpu",
    )


def _versions() -> dict[str, str | None]:
    return {
        "mjxwalk": mjxwalk.__version__,
        "python": platform.python_version(),
        **manifest.versions(),
    }
