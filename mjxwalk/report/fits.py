"""The page on oscillators fitted to a gait, beside the thesis' own parameters."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import jax
import numpy as np

from mjxwalk import gaits
from mjxwalk.analysis import fit_figures, fits
from mjxwalk.analysis.fits import Fit
from mjxwalk.controllers.patterns import FourJoints, stride_time
from mjxwalk.controllers.rayleigh import JOINTS
from mjxwalk.errors import RunError
from mjxwalk.fitting import Fitting
from mjxwalk.report import drawing, provenance_section
from mjxwalk.report.parts import (
    NOTHING,
    Cell,
    Column,
    Page,
    Picture,
    Row,
    RowGroup,
    Section,
    Table,
    cells,
    count,
    frame,
    number,
)
from mjxwalk.report.sources import Phase, Source

REFERENCES = (
    'The thesis: "Designing CPG for Biped Locomotion Control using Nonlinear Dynamical Theory", '
    "Indian Institute of Information Technology, Allahabad. Its amplitudes, frequencies, centres, "
    "starts and human data are not in it; ours stand in for them, in both columns.",
    'Adults: Fukuchi, Fukuchi & Duarte (2018), "A public dataset of overground and treadmill '
    'walking kinematics and kinetics in healthy individuals", PeerJ 6:e4640, data at doi '
    "10.6084/m9.figshare.5722711, CC BY 4.0.",
)
KICK = 0.2  # ours: what is left of the left leg's swing


def is_fit(source: Source) -> bool:
    """Returns whether a source is a run of a fit."""
    return isinstance(source.phases[0].experiment, Fitting)


def build(read: Sequence[Source]) -> Page:
    """Returns the page on runs that are all of one fit.

    Raises:
      RunError: they are of several experiments, or not all are fits.
    """
    phases = [phase for source in read for phase in source.phases]
    for phase in phases[1:]:
        if phase.experiment.name != phases[0].experiment.name:
            raise RunError(
                f"{phases[0].label} is of {phases[0].experiment.name} and {phase.label} of "
                f"{phase.experiment.name}; report on them apart"
            )
    # Several runs of a fit are searches for the same optimum; the page is on the best.
    phase = max(phases, key=_best_fitness)
    experiment = phase.experiment
    ours = fits.measure(experiment, _genotype(phase))
    return Page(
        title=f"{experiment.name}, {count(len(read), 'run')}",
        lead=(_lead(phase, ours, len(phases)),),
        remarks=(),
        sections=(
            provenance_section.section(read),
            _errors(experiment, ours),
            _parameters(phase),
            _course(phase, ours),
            _limit_cycle(phase),
            _demonstrations(),
        ),
        references=REFERENCES,
    )


def _genotype(phase: Phase) -> Any:
    return jax.tree.map(np.asarray, phase.walker.genotype)


def _best_fitness(phase: Phase) -> float:
    return float(np.nanmax(phase.run.metrics["best_fitness"]))


def _lead(phase: Phase, ours: Fit, num: int) -> str:
    which = "" if num == 1 else f" The best is of {phase.label}, and all below is on it."
    hip, knee = ours.rms[:2].max(), ours.rms[2:].max()
    settled = ours.settled_rms[:2].max(), ours.settled_rms[2:].max()
    return (
        f"{phase.experiment.describe()}: {number(hip, 1)} degrees off at the hips and "
        f"{number(knee, 1)} at the knees (root mean square over the cycle) while the human's clock "
        f"runs, {number(settled[0], 1)} and {number(settled[1], 1)} on the cycle that they settle "
        f"to.{which}"
    )


def _thesis(experiment: Any) -> tuple[Any, Any]:
    """Returns the thesis' network on the same gait by the same measure, and its genotype."""
    network = FourJoints()
    return dataclasses.replace(experiment, network=network), network.template()


def _errors(experiment: Any, ours: Fit) -> Section:
    thesis = fits.measure(*_thesis(experiment))
    bounds = [_bound(ours.human[:, place]) for place in range(len(JOINTS))]
    columns = {
        ("ours", "by the human's clock"): ours.rms,
        ("ours", "settled"): ours.settled_rms,
        ("thesis' Table 1", "by the human's clock"): thesis.rms,
        ("thesis' Table 1", "settled"): thesis.settled_rms,
        ("", "best single sine"): np.array(bounds),
    }
    rows = [
        Row(name, cells(*(number(float(values[place]), 2) for values in columns.values())))
        for place, name in enumerate(JOINTS)
    ]
    data = [
        {"joint": name}
        | {f"{group} {title}".strip(): values[place] for (group, title), values in columns.items()}
        for place, name in enumerate(JOINTS)
    ]
    table = Table(
        name="errors",
        caption="Error of each joint, degrees (root mean square over the gait cycle)",
        head="joint",
        columns=tuple(Column(title, group) for group, title in columns),
        groups=(RowGroup("", tuple(rows)),),
        data=frame(data),
        note=(
            f"By the human's clock: over {count(experiment.cycles, 'cycle')} after "
            f"{count(experiment.settling_cycles, 'cycle')} from a start in the human's phase. "
            "Settled: the oscillators' own cycle long after, shifted in time as a whole to where "
            "it fits best. A single sine is what one oscillator a joint could draw at best, but "
            "for its overtones."
        ),
    )
    return Section(anchor="errors", title="How well they fit", parts=(table,))


def _bound(curve: Any) -> float:
    phase = 2 * np.pi * np.arange(len(curve)) / len(curve)
    off = curve - gaits.evaluate(gaits.harmonics(curve, 1), phase)
    return float(np.sqrt(np.mean(off**2)))


def _parameters(phase: Phase) -> Section:
    experiment = phase.experiment
    thesis: dict[str, float] = {}
    if isinstance(experiment.network, FourJoints):
        thesis = dict(experiment.network.table(experiment.network.template()))
    found = experiment.weight_table(_genotype(phase))
    rows = [
        Row(name, (Cell(number(value, 4)), Cell(_quoted(thesis.get(name)), is_quoted=True)))
        for name, value in found
    ]
    data = [{"parameter": name, "ours": value, "thesis": thesis.get(name)} for name, value in found]
    table = Table(
        name="table-1",
        caption="Table 1. Parameters",
        head="parameter",
        columns=(Column("ours"), Column("thesis")),
        groups=(RowGroup("", tuple(rows)),),
        data=frame(data),
        note="k and alpha in 1/s, k13, k24, k31 and k42 in 1/(degree s), as far as they have units "
        "in the thesis; weights and centres in degrees.",
    )
    errors = -np.fmax.accumulate(np.asarray(phase.run.metrics["best_fitness"], np.float64))
    drawn = fit_figures.error_over_generations(errors, experiment.unit)
    picture = Picture(
        name="error",
        caption="The error that evolution lowers: c1 |e| + c2 |de/dt| + c3 |integral of e|.",
        svg=drawing.inline(
            drawn,
            name="error",
            alt=f"The error falls from {errors[0]:.2f} to {errors[-1]:.2f} in {len(errors)} "
            "generations.",
        ),
        data=frame([{"generation": 1 + g, "error": error} for g, error in enumerate(errors)]),
    )
    return Section(anchor="parameters", title="What was found", parts=(table, picture))


def _quoted(value: float | None) -> str:
    return NOTHING if value is None else number(value, 4)


def _course(phase: Phase, ours: Fit) -> Section:
    experiment = phase.experiment
    cycle_s = stride_time(experiment.target())
    parts: list[Picture] = []
    for who, fit in (("ours", ours), ("thesis", fits.measure(*_thesis(experiment)))):
        whose = "Ours" if who == "ours" else "The thesis' Table 1"
        ranges = ", ".join(
            f"{name} from {fit.angle[:, place].min():.0f} to {fit.angle[:, place].max():.0f}"
            for place, name in enumerate(JOINTS)
        )
        drawn = (
            (
                "5-1",
                "Figure 5.1",
                "The angles over time; dotted: human",
                fit_figures.angles_over_time,
            ),
            ("5-2", "Figures 5.2 to 5.5", "Limit cycles; dotted: human", fit_figures.limit_cycles),
            ("5-6", "Figure 5.6", "The angular velocities over time", fit_figures.rates_over_time),
        )
        for place, title, what, draw in drawn:
            name = f"figure-{place}-{who}"
            parts.append(
                Picture(
                    name=name,
                    caption=f"{title}. {whose}. {what}.",
                    svg=drawing.inline(
                        draw(fit, cycle_s), name=name, alt=f"{what} of {whose}: {ranges} degrees."
                    ),
                    data=_motion(fit, cycle_s) if place == "5-1" else None,
                )
            )
    return Section(anchor="course", title="What they draw", parts=tuple(parts))


def _motion(fit: Fit, cycle_s: float) -> Any:
    time = cycle_s / len(fit.human) * np.arange(len(fit.angle))
    columns = {"time_s": time}
    for place, name in enumerate(JOINTS):
        columns[f"{name} (degrees)"] = fit.angle[:, place]
        columns[f"{name} (degrees/s)"] = fit.rate[:, place]
    return frame(
        [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    )


def _limit_cycle(phase: Phase) -> Section:
    course = fits.kick(phase.experiment, _genotype(phase), factor=KICK)
    first, last = course.distance[0], course.distance[-1]
    text = (
        f"Long after the start the left leg's swing was cut to {KICK:.0%}. In the cycle after "
        f"that the angles were up to {number(first, 1)} degrees off the cycle they came from, "
        f"{count(len(course.distance), 'cycle')} later {number(last, 1)} degrees."
    )
    picture = Picture(
        name="kick",
        caption="A kick and the way back: the dot is where it begins, the thick line the cycle.",
        svg=drawing.inline(fit_figures.kicked(course), name="kick", alt=text),
        data=frame([{"cycle": 1 + n, "degrees_off": off} for n, off in enumerate(course.distance)]),
    )
    return Section(anchor="kick", title="Is it a limit cycle?", texts=(text,), parts=(picture,))


def _demonstrations() -> Section:
    picture = Picture(
        name="figure-2",
        caption="Figures 2.4 to 2.8. One oscillator: what p and mu do.",
        svg=drawing.inline(
            fit_figures.one_oscillator(),
            name="figure-2",
            alt="Five panels: oscillations that start at 0.1 and settle; with p ten times as large "
            "they are a third as high, with mu twice as large nearly twice as fast.",
        ),
    )
    return Section(anchor="oscillator", title="One oscillator", parts=(picture,))
