"""Runs all measurements, one after the other."""

import dataclasses
import os
import platform
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, NamedTuple

import jax

import mjxwalk
from mjxwalk.bench import bodies, child, contenders, timing
from mjxwalk.bench.bodies import Body
from mjxwalk.bench.evolved import Evolved
from mjxwalk.bench.peak import Peak
from mjxwalk.bench.results import (
    Arithmetic,
    CompileSeconds,
    Evolution,
    Machine,
    Results,
    Scaling,
    Speed,
)
from mjxwalk.engines import lanes
from mjxwalk.engines.lanes.runtime.thread_pool import num_threads
from mjxwalk.engines.selection import num_cores
from mjxwalk.runs import manifest

MAIN = "planar"  # the body that everything but the engines' speed is measured with
PEAK = "peak"
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
    """

    quick: bool
    population: int
    seconds: float
    repeats: int
    generations: int
    populations: tuple[int, ...]
    shortest: int
    xla: bool = False


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


class Engines(NamedTuple):
    """Speed of the engines with one body, and the CPU's peak in operations/s meanwhile."""

    speed: Speed
    peak: float
    mapped: lanes.Mapped


def measure(sizes: Sizes, say: Say) -> Results:
    """Returns what was measured.

    Args:
      sizes: how much.
      say: is told what is being measured.
    """
    machine = _machine()
    main = bodies.BODIES[MAIN]
    say("compiling, and evolving what is to be timed")
    fields, left_out, evolved = _prepare(main, sizes, machine.accelerator)
    measured: dict[str, Engines] = {}
    for name in bodies.BODIES:
        say(f"measuring the engines with the {name} body")
        measured[name] = engines(fields[name], sizes, left_out[name])
    say("measuring how long compiling takes, without and with the disk cache")
    cold, warm = child.compile_seconds(MAIN)
    say(f"measuring trials of populations as they evolve, {sizes.generations} generations")
    evolution = evolve(main, evolved, sizes)
    say("measuring populations from small to large")
    scaling = scale(main, sizes)
    return Results(
        quick=sizes.quick,
        repeats=sizes.repeats,
        speeds={body: found.speed for body, found in measured.items()},
        compile_s=CompileSeconds(cold=cold, warm=warm),
        evolution=evolution,
        population_scaling=scaling,
        arithmetic=arithmetic(measured[MAIN]),
        machine=machine,
        versions=_versions(),
    )


def _prepare(
    main: Body, sizes: Sizes, accelerator: bool
) -> tuple[dict[str, dict[str, Any]], dict[str, dict[str, str]], Any]:
    """Returns each body's contenders, compiled, those left out and why, and what has evolved.

    XLA compiles in a thread of its own, while the other core does all else.
    """
    fields: dict[str, dict[str, Any]] = {}
    left_out: dict[str, dict[str, str]] = {}
    with ThreadPoolExecutor(1) as other:
        compiling: list[Future[int]] = []
        for name, body in bodies.BODIES.items():
            slow = body.slow and sizes.quick and not accelerator
            left_out[name] = {"mjx": TOO_SLOW} if slow else {}
            fields[name] = contenders.make(
                body,
                sizes.population,
                num_threads(),
                xla=sizes.xla or accelerator,
                without=left_out[name],
            )
            by_xla = [rival for rival in ("mjx", "lanes_xla") if rival in fields[name]]
            compiling += [other.submit(fields[name][rival], 1) for rival in by_xla]
        for field in fields.values():
            field["lanes"](1)
        evolved = Evolved(main.study(), sizes.generations)
        for compiled in compiling:
            compiled.result()
    return fields, left_out, evolved


def engines(rivals: Mapping[str, Any], sizes: Sizes, left_out: Mapping[str, str]) -> Engines:
    """Returns how fast the engines are with one body, in turn with the CPU's peak.

    Args:
      rivals: contenders by name.
      sizes: how much is measured.
      left_out: the contenders that are not, and why.
    """
    field = {**rivals, PEAK: Peak(num_threads())}
    amounts = {name: timing.calibrate(one, sizes.seconds) for name, one in field.items()}
    timings = timing.in_turn(field, amounts, sizes.repeats)
    rates = {name: timing.rate(timings[name]) for name in field}
    peak = rates.pop(PEAK)
    del amounts[PEAK]
    mapped = rivals["lanes"].mapped
    kernel = mapped.compiled
    assert kernel is not None  # it has run
    speed = Speed(
        population=sizes.population,
        operations_per_step=kernel.operations,
        steps_per_s=rates,
        steps_per_walker=amounts,
        left_out=left_out,
    )
    return Engines(speed, peak, mapped)


def arithmetic(measured: Engines) -> Arithmetic:
    """Returns how near to the CPU's peak the lanes engine came."""
    kernel = measured.mapped.compiled
    assert kernel is not None  # it has run
    return Arithmetic(
        operations_per_step=kernel.operations,
        steps_per_s=measured.speed.steps_per_s["lanes"],
        peak_gflops=1e-9 * measured.peak,
        width=kernel.target.width,
        threads=measured.mapped.threads,
    )


def evolve(body: Body, evolved: Any, sizes: Sizes) -> Evolution:
    """Returns how fast populations that evolve run, in turn with one where nobody falls early."""
    level = contenders.Engine(lanes.vmap, bodies.workload(body, evolved.size))
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


def scale(body: Body, sizes: Sizes) -> Scaling:
    """Returns what a step costs in small and large populations."""
    field = {
        str(size): contenders.Engine(lanes.vmap, bodies.workload(body, size))
        for size in sizes.populations
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
