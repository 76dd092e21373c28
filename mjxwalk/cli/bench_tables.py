"""The results in words: tables on a terminal, plain lines elsewhere."""

import sys
from typing import NamedTuple

from rich.console import Console
from rich.table import Table

from mjxwalk import terminal
from mjxwalk.bench.contenders import LINEAR
from mjxwalk.bench.names import BODIES, MAIN
from mjxwalk.bench.results import REFERENCE, Evolution, Results, Scaling, Speed
from mjxwalk.cli.progress_text import count

MEBIBYTE = 1 << 20
SAME_WORK = (
    "where C MuJoCo has no contacts: every walker of ours takes the same number of steps, with "
    "contacts and control; the rules of a trial are computed but end nobody"
)
CONTROL = (
    "where it has: the same policies, starts and trials of a second on both sides; every fifth "
    "step a policy of the walker's own reads positions and velocities, and motors hold its targets",
    "mujoco_batch: the policies in NumPy, between calls of five steps; mujoco_rollout: one call of "
    "all steps, with the controls of such a trial; mjx: mjx.step of the same model",
)
OPTIONS = "MuJoCo's contacts: Euler, 1 iteration of Newton's method and 4 of its line search"
FILE_OPTIONS = "MuJoCo's contacts: integrator and iterations of the bodies' files, Newton's method"


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
    main = [_evolution(results.evolution), _scaling(results.population_scaling)]
    return [_speeds(results), _kernels(results), *(each for each in main if each)]


def lines(section: Section) -> list[str]:
    """Returns a table as lines of text, the first column to the left, the others to the right."""
    cells = [section.columns, *section.rows] if any(section.columns) else section.rows
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    shown = [
        "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]) for row in cells
    ]
    return [section.title, *(f"  {line.rstrip()}" for line in shown), *section.remarks, ""]


def _speeds(results: Results) -> Section:
    speeds = results.speeds
    rivals = list(dict.fromkeys(name for each in speeds.values() for name in each.ratios))
    rows = [
        (
            body,
            count(speed.steps_per_s[REFERENCE]),
            *(cell for name in rivals for cell in _rival(speed, name)),
        )
        for body, speed in speeds.items()
    ]
    columns = ("body", REFERENCE, *(cell for name in rivals for cell in (name, "x")))
    sizes = {f"{speed.population:,}" for speed in speeds.values()}
    title = (
        f"steps/s, and how many times as fast {REFERENCE} is; {' or '.join(sizes)} walkers, "
        f"medians of {results.repeats} timings in turn"
    )
    return Section(title, columns, rows, _remarks(results))


def _rival(speed: Speed, name: str) -> tuple[str, str]:
    if name not in speed.ratios:
        return "-", "-"
    return count(speed.steps_per_s[name]), f"{speed.ratios[name]:.3g}"


def _remarks(results: Results) -> list[str]:
    machine = results.machine
    threads = max(speed.kernel.threads for speed in results.speeds.values())
    remarks = [f"{body}: {BODIES[body]}" for body in results.speeds]
    if any(speed.contacts is not None for speed in results.speeds.values()):
        remarks += [*CONTROL, OPTIONS if not results.file_options else FILE_OPTIONS]
    if any(speed.contacts is None for speed in results.speeds.values()):
        remarks.append(SAME_WORK)
    if any(LINEAR in speed.ratios for speed in results.speeds.values()):
        remarks.append(f"{LINEAR}: {REFERENCE} with a linear policy in place of the network")
    remarks += [
        f"{body}: {name} left out: {why}"
        for body, speed in results.speeds.items()
        for name, why in speed.left_out.items()
    ]
    remarks += [f"{body}: left out: {why}" for body, why in results.absent.items()]
    remarks.append(
        f"{REFERENCE} and C MuJoCo run on {threads} CPU threads, mjx on {machine.mjx_devices}"
    )
    if machine.accelerator:
        remarks.append(f"mjx ran on an accelerator: {machine.mjx_devices}")
    load = "" if machine.load_average is None else f", load {machine.load_average:.1f} at the start"
    packages = [f"{name} {version}" for name, version in results.versions.items() if version]
    return [
        *remarks,
        f"{machine.cpu}, {machine.cores} cores, {machine.usable_cores} to use{load}",
        ", ".join(packages),
    ]


def _kernels(results: Results) -> Section:
    rows = [_kernel(body, speed) for body, speed in results.speeds.items()]
    columns = (
        "body", "operations", "of the peak", "width", "cold", "warm", "code", "contacts", "stopped",
        "warnings",
    )  # fmt: skip
    remarks = [
        "operations: scalar ones of a step, comparisons and selections included, and the control's "
        "share; a multiply-add is two",
        "of the peak: of multiply-adds at this width on these threads, measured in turn",
        "cold, warm: tracing and compiling in a fresh process, without and with the disk cache",
        "contacts: active ones of a walker of C MuJoCo, on the average of its trials",
        "stopped: walkers of lanes whose physics diverged; warnings: simulations of C MuJoCo whose "
        "did",
    ]
    return Section("the kernels of lanes, and what was met", columns, rows, remarks)


def _kernel(body: str, speed: Speed) -> tuple[str, ...]:
    kernel, share = speed.kernel, speed.kernel.share_of_peak
    return (
        body,
        f"{kernel.operations_per_step:,}" if share is not None else "-",
        "-" if share is None else f"{share:.0%}",
        f"{kernel.width} x {kernel.threads}",
        f"{kernel.compile_cold_s:.1f} s",
        f"{kernel.compile_warm_s:.2f} s",
        f"{kernel.code_bytes / 1024:,.0f} KiB",
        "-" if speed.contacts is None else f"{speed.contacts:.1f}",
        f"{speed.stopped}",
        f"{speed.warnings}",
    )


def _scaling(scaling: Scaling | None) -> Section | None:
    if scaling is None:
        return None
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
    return Section(f"cost of a walker's step, lanes, {MAIN}", columns, rows, remarks)


def _evolution(evolution: Evolution | None) -> Section | None:
    if evolution is None:
        return None
    rows = [
        ("steps/s", count(evolution.steps_per_s)),
        ("of the steps/s where nobody falls", f"{evolution.share_of_peak:.0%}"),
        ("lane utilisation", f"{evolution.lane_utilisation:.0%}"),
    ]
    return Section(f"generations 1 to {evolution.generations}, {MAIN}", ("", ""), rows, [])


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
