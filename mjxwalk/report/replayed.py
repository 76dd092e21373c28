"""The best walker of the last phase, as it walks: the page of `mjxwalk watch` inside a report."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence

from mjxwalk import shell
from mjxwalk.envs.anatomy import anatomy_of
from mjxwalk.player import page, recording, shown_walkers
from mjxwalk.player.recording import Take
from mjxwalk.player.shown_walkers import ShownWalkers
from mjxwalk.report.parts import Replay, Section
from mjxwalk.report.recorded import Recorded
from mjxwalk.report.sources import Phase

SECONDS = 20.0  # ours: a dozen strides and more, in some 60 kB


def section(
    variants: Mapping[str, Sequence[Phase]],
    recorded: Mapping[str, Recorded],
    *,
    seed: int,
    say: Callable[[str], None],
) -> Section | None:
    """Returns the replay of the winner that falls least; None where there is none to be shown.

    Args:
      variants: by phase, in their order; the last that was recorded is shown, of bodies that cannot
        be recorded the first run of the last.
      recorded: by phase; which of its winners falls least stands in it.
      seed: of the terrain.
      say: is told what begins.
    """
    names = [name for name in variants if name in recorded] or [
        name for name, phases in variants.items() if _has_anatomy(phases[0])
    ]
    if not names:
        return None
    name = names[-1]
    say(f"recording a replay of {name}")
    phase = variants[name][0]
    if name in recorded:
        label = recorded[name].stick.label
        phase = next(each for each in variants[name] if each.label == label)
    show, series = recording.perform(_shown(phase), Take(terrain_seed=seed, seconds=SECONDS))
    return Section(
        anchor="replay",
        title="The champion walks",
        texts=(
            "Press play, or turn it with the mouse. It is drawn from the coordinates of a trial on "
            "new ground; left is blue, right is orange, and the green arrow is the ground's force.",
        ),
        commands=(shell.command("watch", phase.run.path),),
        parts=(
            Replay(
                name="replay",
                show=page.as_script(show),
                series=series,
                why=f"{phase.label}: {show.walkers[0].why}.",
            ),
        ),
    )


def _shown(phase: Phase) -> ShownWalkers:
    shown = shown_walkers.of_walker(phase.walker)
    return dataclasses.replace(shown, source=phase.label, experiment=phase.experiment.as_tested())


def _has_anatomy(phase: Phase) -> bool:
    return anatomy_of(getattr(phase.experiment, "env", None)) is not None
