"""The results in words: tables on a terminal, plain lines elsewhere."""

import sys
from typing import NamedTuple

from rich.console import Console
from rich.table import Table

from mjxwalk import terminal
from mjxwalk.bench.bodies import BODIES, SAME_WORK
from mjxwalk.bench.results import REFERENCE, Results, Speed
from mjxwalk.cli.progress_text import count

MEBIBYTE = 1 << 20


class Section(NamedTuple):
    """A table: what it is of, the names of its columns, its rows, and remarks below."""

    title: str
    columns: tuple[str, ...]
    rows: list[tuple[str, ...]]
    remarks: list[str]


def show(results: Results) -> None:
    """Prints the results."""
    if sys.stdout.isatty():
        console = terminal.console()
        for section in sections(results):
            _show_table(console, section)
        return
    for section in sections(results):
        for line in lines(section):
            print(line)


def sections(results: Results) -> list[Section]:
    """Returns the results as tables."""
    speeds = [_speed(body, speed, results) for body, speed in results.speeds.items()]
    return [*speeds, _scaling(results), _figures(results)]


def lines(section: Section) -> list[str]:
    """Returns a table as lines of text, the first column to the left, the others to the right."""
    cells = [section.columns, *section.rows] if any(section.columns) else section.rows
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    shown = [
        "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]) for row in cells
    ]
    return [section.title, *(f"  {line.rstrip()}" for line in shown), *section.remarks, ""]


def _speed(body: str, speed: Speed, results: Results) -> Section:
    where = {
        "lanes": f"{results.arithmetic.threads} CPU threads",
        "lanes_xla": results.machine.mjx_devices,
        "mjx": results.machine.mjx_devices,
        "mujoco_rollout": f"{results.arithmetic.threads} CPU threads",
    }
    rows = [
        (
            name,
            where.get(name, ""),
            count(rate),
            "" if name == REFERENCE else f"{REFERENCE} / {name} = {speed.ratio(name):.3g}",
            f"{speed.steps_per_walker[name]:,}",
        )
        for name, rate in speed.steps_per_s.items()
    ]
    title = f"{body} body, {speed.population:,} walkers, medians of {results.repeats} in turn"
    remarks = [
        f"controller: {BODIES[body].controller}",
        f"lanes: {speed.operations_per_step:,} operations a step",
        SAME_WORK,
        "mujoco_rollout: C MuJoCo, the same model, contacts and constraints off, no controller",
    ]
    remarks += [f"{name} left out: {why}" for name, why in speed.left_out.items()]
    if {"lanes_xla", "mjx"} <= speed.steps_per_s.keys():
        faster = speed.steps_per_s["lanes_xla"] / speed.steps_per_s["mjx"]
        remarks.append(f"lanes_xla / mjx = {faster:.3g}, both on {results.machine.mjx_devices}")
    if results.machine.accelerator:
        remarks.append(f"mjx ran on an accelerator: {results.machine.mjx_devices}")
    columns = ("engine", "runs on", "steps/s", "ratio", "steps a walker")
    return Section(title, columns, rows, remarks)


def _scaling(results: Results) -> Section:
    scaling = results.population_scaling
    cheapest = min(scaling.ns_per_step.values())
    rows = [
        (
            f"{size:,}",
            f"{cost:.1f} ns",
            f"{cost / cheapest - 1:+.0%}",
            f"{scaling.steps_per_walker[size]:,}",
        )
        for size, cost in scaling.ns_per_step.items()
    ]
    peak, before = scaling.peak_memory_bytes, scaling.memory_before_bytes
    remarks = [
        f"peak memory of a process with {max(scaling.ns_per_step):,} walkers: "
        f"{peak / MEBIBYTE:,.0f} MiB, {before / MEBIBYTE:,.0f} MiB before they are there"
    ]
    columns = ("population", "cost a step", "over the least", "steps a walker")
    return Section("cost of a walker's step, lanes", columns, rows, remarks)


def _figures(results: Results) -> Section:
    evolution, units, machine = results.evolution, results.arithmetic, results.machine
    generations = f"generations 1 to {evolution.generations}"
    rows = [
        ("compile, empty disk cache", f"{results.compile_s.cold:.2f} s"),
        ("compile, from the disk cache", f"{results.compile_s.warm:.3f} s"),
        (f"steps/s in {generations}", count(evolution.steps_per_s)),
        ("  of the peak steps/s", f"{evolution.share_of_peak:.0%}"),
        ("  lane utilisation", f"{evolution.lane_utilisation:.0%}"),
        ("operations a step", f"{units.operations_per_step:,}"),
        ("operations a second", f"{units.gflops:.3g} GFLOP/s"),
        ("peak, multiply-adds", f"{units.peak_gflops:.3g} GFLOP/s"),
        ("share of that peak", f"{units.share_of_peak:.0%}"),
        ("vector width, threads", f"{units.width} x {units.threads}"),
    ]
    load = "" if machine.load_average is None else f", load {machine.load_average:.1f} at the start"
    packages = [f"{name} {version}" for name, version in results.versions.items() if version]
    remarks = [
        "operations: scalar ones of the kernel's loop, comparisons and selections included; a "
        "multiply-add is two",
        f"{machine.cpu}, {machine.cores} cores, {machine.usable_cores} to use{load}",
        ", ".join(packages),
    ]
    return Section("lanes with the planar body", ("", ""), rows, remarks)


def _show_table(console: Console, section: Section) -> None:
    named = any(section.columns)
    table = Table(title=section.title, title_justify="left", show_header=named)
    for number, column in enumerate(section.columns):
        table.add_column(column, justify="left" if number == 0 else "right")
    for row in section.rows:
        table.add_row(*row)
    console.print(table)
    for remark in section.remarks:
        console.print(remark, style="dim", markup=False)
    console.print()
