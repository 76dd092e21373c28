"""How the winners walk: gaits, stick figures and angles of bodies with two feet.

Of bodies of the paper these are Table 5 and Figures 5, 6 and 8 of Solomon, Locascio & Hartmann
(2013), beside its numbers.
"""

from collections.abc import Mapping

import numpy as np

from mjxwalk.analysis import figures, paper, sticks, tables
from mjxwalk.analysis.frame import Frame
from mjxwalk.analysis.gait import Gait
from mjxwalk.report import drawing
from mjxwalk.report.parts import (
    LOST,
    NOTHING,
    Cell,
    Column,
    Picture,
    Row,
    RowGroup,
    Section,
    Table,
    cells,
    count,
    frame,
    number,
    quoted,
    spread,
)
from mjxwalk.report.recorded import LOOKED_AT, Recorded

PLACES = {  # of the figures of a gait, with their titles
    "speed_m_s": ("speed (m/s)", 2),
    "step_length_m": ("step length (m)", 3),
    "double_stance": ("double stance (% of a stride)", 1),
    "stride_time_s": ("duration of a stride (s)", 2),
    "swing_time_s": ("duration of a swing (s)", 2),
    "cost_of_transport": ("cost of transport", 3),
}
FAULTS = {  # of a spatial gait, with their titles, factors and places
    "slip": ("soles slide (% of the way)", 100, 1),
    "brush": ("a swinging foot brushes the ground (% of its swing)", 100, 1),
    "flight": ("no foot touches the ground (% of the time)", 100, 1),
    "drift": ("drift sideways (% of the way)", 100, 1),
    "pitch_rad": ("lean of the torso forward or back (rad)", 1, 3),
    "roll_rad": ("roll of the torso (rad)", 1, 3),
}
SIGNS = (
    "The torso that leans forward, hips and knees that bend and ankles that lift the toe count as "
    "positive; 0 is the pose in which the file has the joints."
)
PAPER = Column("paper")  # columns of numbers that are published
ADULTS, ADULTS_IN_PAPER = Column("adults, measured", "human"), Column("as in the paper", "human")
IN_PAPER = ("speed_m_s", "step_length_m", "double_stance")  # what its table had


def section(recorded: Mapping[str, Recorded], *, why_not: str = "") -> Section:
    """Returns the gait table and the figures of each phase.

    Args:
      recorded: by phase.
      why_not: why there is nothing, if there is not.
    """
    if not recorded:
        return Section(anchor="walking", title="How they walk", texts=(why_not,))
    parts: list[Table | Picture] = [_table(recorded)]
    if any(_is_spatial(each) for each in recorded.values()):
        parts.append(_faults(recorded))
    parts += [_stick(name, each) for name, each in recorded.items()]
    parts += [_density(name, each) for name, each in recorded.items() if each.density.steps]
    still = [name for name, each in recorded.items() if not each.density.steps]
    text = (
        "Every winner was recorded again on new ground. Figures of the gait are of trials without "
        "a fall; of one winner ± is the standard deviation between trials, else between winners."
    )
    if still:
        text += (
            f" There is no figure of the angles of {', '.join(still)}: no whole step was taken in "
            "a trial without a fall."
        )
    return Section(anchor="walking", title="How they walk", texts=(text,), parts=tuple(parts))


def _table(recorded: Mapping[str, Recorded]) -> Table:
    gaits = {name: each.gaits for name, each in recorded.items()}
    data = tables.table_5(gaits)
    is_paper = any(each.is_paper for each in recorded.values())
    others = _others(recorded)
    rows = [
        Row(title, (*_ours(data, name, list(gaits)), *_quoted(name, list(gaits), others)))
        for name, (title, _) in PLACES.items()
    ]
    in_table_5 = not any(_is_spatial(each) or not each.is_paper for each in recorded.values())
    return Table(
        name="table-5" if in_table_5 else "gaits",
        caption="Table 5. Gaits of the winners" if in_table_5 else "Gaits of the winners",
        head="figure",
        columns=(*(Column(name, "ours" if is_paper else "") for name in gaits), *others),
        groups=(RowGroup("", tuple(rows)),),
        data=(data if others else data.loc[list(gaits)]).reset_index(),
        note=_note(recorded),
    )


def _others(recorded: Mapping[str, Recorded]) -> tuple[Column, ...]:
    """Returns the columns of numbers that are published."""
    if any(each.is_paper for each in recorded.values()):
        return (PAPER, ADULTS, ADULTS_IN_PAPER)
    return (ADULTS,) if any(each.is_beside_adults for each in recorded.values()) else ()


def _note(recorded: Mapping[str, Recorded]) -> str:
    others = _others(recorded)
    told = "; ".join(f"{name}: {_basis(each.gaits)}" for name, each in recorded.items())
    told = f"Without a fall, {told}."
    if PAPER in others:
        return (
            f"{told} The paper's numbers are lost; it calls speed and step length those of a "
            "slightly brisk human, and double stance notably briefer than a human's. Adults: "
            f"{paper.FUKUCHI}; in the paper: {paper.HUMAN_IN_PAPER['double_stance'].source}."
        )
    return f"{told} Adults, of a human's size and weight: {paper.FUKUCHI}." if others else told


def _faults(recorded: Mapping[str, Recorded]) -> Table:
    """Returns what spatial gaits hide."""
    import pandas as pd

    known = {name: each.faults for name, each in recorded.items() if each.faults is not None}
    data = pd.concat(known, names=["phase", "run"])
    means, deviations = (
        getattr(data.groupby(level="phase", sort=False), of)() for of in ("mean", "std")
    )
    rows = [
        Row(
            title,
            cells(
                *(
                    spread(scale * means.loc[phase, name], scale * deviations.loc[phase, name], num)
                    for phase in recorded
                )
            ),
        )
        for name, (title, scale, num) in FAULTS.items()
    ]
    return Table(
        name="faults",
        caption="What the gaits of the winners may hide",
        head="figure",
        columns=tuple(Column(name) for name in recorded),
        groups=(RowGroup("", tuple(rows)),),
        data=data.reset_index(),
        note=(
            f"Means over {LOOKED_AT} trials of each winner, absolute values; ± between winners. "
            "A sole slides as fast as the slowest of its corners that touch the ground."
        ),
    )


def _is_spatial(recorded: Recorded) -> bool:
    return recorded.faults is not None


def _ours(data: Frame, name: str, variants: list[str]) -> tuple[Cell, ...]:
    places, scale = PLACES[name][1], _scale(name)
    return tuple(
        Cell(
            spread(scale * data.loc[variant, name], scale * data.loc[variant, f"{name}_sd"], places)
        )
        for variant in variants
    )


def _quoted(name: str, variants: list[str], others: tuple[Column, ...]) -> tuple[Cell, ...]:
    """Returns what is published of a figure, a cell for each of the columns."""
    is_lost = any(variant in paper.VARIANTS for variant in variants) and name in IN_PAPER
    places, scale = PLACES[name][1], _scale(name)
    known = {
        PAPER: Cell(LOST if is_lost else NOTHING, is_quoted=True),
        ADULTS: quoted(paper.HUMAN.get(name), places, scale=scale),
        ADULTS_IN_PAPER: quoted(paper.HUMAN_IN_PAPER.get(name), places, scale=scale),
    }
    return tuple(known[column] for column in others)


def _scale(name: str) -> int:
    return 100 if name == "double_stance" else 1


def _basis(gaits: tuple[Gait, ...]) -> str:
    trials, falls = (sum(getattr(gait, name) for gait in gaits) for name in ("trials", "falls"))
    strides = sum(gait.strides for gait in gaits)
    return f"{count(strides, 'stride')} in {trials - falls:,} of {trials:,} trials"


def _stick(name: str, recorded: Recorded) -> Picture:
    stick, spatial = recorded.stick, _is_spatial(recorded)
    num = len(stick.sticks.skeletons)
    end = f"; it falls after {stick.seconds:.1f} s" if stick.fell else ""
    walked = float(np.ptp(stick.sticks.skeletons[:, 0, 1, 0]))
    in_paper = recorded.is_paper and not spatial
    place = f"figure-5-{name}" if in_paper else f"sticks-{name}"
    alt = (
        f"{count(num, 'stick figure')} of a walker with torso, thighs, shanks and feet, side by "
        f"side on uneven ground; its hip gets {walked:.1f} m forward in {stick.seconds:.1f} s{end}."
    )
    return Picture(
        name=place,
        caption=(
            f"{'Figure 5' if in_paper else 'Stick figures'}, {name}. The winner of {stick.label} "
            f"from its start, every half second{end}. "
            + ("Below, from the front. The left" if spatial else "The right")
            + " leg is the faint one."
        ),
        svg=drawing.inline(sticks.draw(stick.sticks), name=place, alt=alt),
    )


def _density(name: str, recorded: Recorded) -> Picture:
    density = recorded.density
    figure = "Figure 8" if _is_spatial(recorded) else "Figure 6"
    if not recorded.is_paper:
        figure = "Angles"
    place = f"{figure.lower().replace(' ', '-')}-{name}"
    courses = [
        f"{angle} from {number(course.min(), 0)} to {number(course.max(), 0)} degrees"
        for angle, course in zip(density.names, density.mean, strict=True)
    ]
    alt = f"{len(density.names)} panels, an angle each. Averages over a step: {', '.join(courses)}."
    middles = (np.arange(density.mean.shape[1]) + 0.5) / density.mean.shape[1]
    data = {"step": middles, **dict(zip(density.names, density.mean, strict=True))}
    return Picture(
        name=place,
        caption=(
            f"{figure}, {name}. How often each angle is where over a step, of "
            f"{count(density.steps, 'step')} of {count(len(recorded.labels), 'winner')} in trials "
            "without a fall. "
            + ("" if recorded.is_paper else f"{SIGNS} ")
            + "The file has the average courses."
        ),
        svg=drawing.inline(figures.angle_densities(density), name=place, alt=alt),
        data=frame([dict(zip(data, row, strict=True)) for row in zip(*data.values(), strict=True)]),
    )
