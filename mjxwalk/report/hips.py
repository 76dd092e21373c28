"""The page on a hip-powered biped: Figures 9 to 11 and 13 to 16 of Reil & Massey (2001)."""

from collections.abc import Callable, Mapping, Sequence

import jax
import numpy as np

from mjxwalk import replay
from mjxwalk.analysis import figures, hip_figures
from mjxwalk.analysis.hip_figures import Course
from mjxwalk.envs.anatomy import anatomy_of
from mjxwalk.report import drawing, fitness, winners
from mjxwalk.report.parts import Picture, Section, frame, number
from mjxwalk.report.sources import Phase, Source

REFERENCES = (
    'The paper: Reil & Massey (2001), "Facilitating controller evolution in morpho-functional '
    'machines - a bipedal case study".',
)
# What evolves with assistance is shown alone, then followed by what evolves without.
ASSISTED = "assisted"
FITNESS_TEXT = (
    "Fitness is the hindmost foot's distance, at most the 20 m at which a trial ends. In the "
    "paper the fittest reaches 20 m in less than 100 generations with assistance (Figure 9), and "
    "soon again once it is taken away (Figure 10); without any it never does (Figure 11)."
)
HIPS_TEXT = (
    "The network asks for angles of the hips; motors and body follow. In the paper the desired "
    "angle carries a small second oscillation that the body filters out, and desired and actual "
    "angles lock after a short transient. Thin: from the start on; thick: after "
    f"{hip_figures.SETTLED:g} s."
)


def is_hip_powered(source: Source) -> bool:
    """Returns whether a source is of a biped whose hips alone are powered, and asked for angles."""
    anatomy = anatomy_of(getattr(source.phases[0].experiment, "env", None))
    if anatomy is None:
        return False
    hips = [leg.hip for leg in anatomy.legs]
    return [each.coordinate for each in anatomy.motors] == hips and all(
        each.law == "velocity" for each in anatomy.motors
    )


def sections(
    variants: Mapping[str, Sequence[Phase]],
    *,
    num_trials: int,
    engine: str,
    say: Callable[[str], None],
) -> tuple[Section, ...]:
    """Returns what there is to tell of a hip-powered biped.

    Args:
      variants: by phase, in their order.
      num_trials: 0 to record none.
      engine: that runs the trial.
      say: is told what begins.
    """
    hips = [hips_section(variants, engine=engine, say=say)] if num_trials else []
    return (fitness_section(variants), winners.section(variants), *hips)


def fitness_section(variants: Mapping[str, Sequence[Phase]]) -> Section:
    """Returns Figures 9 and 10, or Figure 11 of runs that never had assistance."""
    parts: list[Picture] = []
    if ASSISTED in variants:
        parts.append(fitness.over_phases({ASSISTED: variants[ASSISTED]}, figure="9"))
    if ASSISTED not in variants or len(variants) > 1:
        parts.append(fitness.over_phases(variants, figure="10" if ASSISTED in variants else "11"))
    return Section(
        anchor="fitness",
        title="Fitness over the generations",
        texts=(FITNESS_TEXT,),
        parts=tuple(parts),
    )


def hips_section(
    variants: Mapping[str, Sequence[Phase]], *, engine: str, say: Callable[[str], None]
) -> Section:
    """Returns Figures 13 to 16 of the best walker of the last phase, from the usual start.

    Args:
      variants: by phase, in their order.
      engine: that runs the trial.
      say: is told what begins.
    """
    phase = max(list(variants.values())[-1], key=_reached)
    say(f"recording the hips of {phase.label}")
    shown = hip_figures.course(_recording(phase, engine), phase.experiment.env.anatomy)
    ranges = ", ".join(
        f"{name} from {number(float(part.min()), 2)} to {number(float(part.max()), 2)} rad"
        for name, part in (
            ("desired left hip", shown.desired[:, 0]),
            ("actual", shown.hip[:, 0]),
            ("left knee", shown.knee[:, 0]),
        )
    )
    drawn = (
        ("13", "Desired and actual hip angles", hip_figures.angles_over_time),
        ("14", "The left hip over the left output", hip_figures.locking),
        ("15", "Right over left hip, desired and actual", hip_figures.attractors),
        ("16", "The left knee over the left hip", hip_figures.limit_cycle),
    )
    parts = [
        Picture(
            name=f"figure-{figure}",
            caption=f"Figure {figure}. {what}; {phase.label}.",
            svg=drawing.inline(draw(shown), name=f"figure-{figure}", alt=f"{what}: {ranges}."),
            data=_numbers(shown) if figure == "13" else None,
        )
        for figure, what, draw in drawn
    ]
    return Section(anchor="hips", title="Hips and knees", texts=(HIPS_TEXT,), parts=tuple(parts))


def _reached(phase: Phase) -> float:
    return float(np.nanmax(phase.run.metrics["best_fitness"]))


def _recording(phase: Phase, engine: str) -> replay.Recording:
    """Returns the trial of a phase's best walker that the paper has: its usual start."""
    env = phase.experiment.env
    genotypes = jax.tree.map(lambda leaf: np.asarray(leaf)[None], phase.walker.genotype)
    given = env.level_trials().given(np.zeros(1, np.int32))
    return replay.record(
        env, phase.experiment.controller, genotypes, given, duration=env.max_time, engine=engine
    )


def _numbers(shown: Course) -> figures.Frame:
    sides = ("left", "right")
    columns = {
        f"{side}_{name}_rad": part[:, leg]
        for name, part in (
            ("desired_hip", shown.desired),
            ("hip", shown.hip),
            ("knee", shown.knee),
        )
        for leg, side in enumerate(sides)
    }
    return frame(
        [
            {"time_s": time, **{name: part[place] for name, part in columns.items()}}
            for place, time in enumerate(shown.time)
        ]
    )
