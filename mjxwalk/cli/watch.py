"""The command `mjxwalk watch`."""

import dataclasses
import math
from pathlib import Path
from typing import TYPE_CHECKING

from mjxwalk import outputs
from mjxwalk.cli.argument_types import OptionalFile, OptionalFloat, Seed, Source
from mjxwalk.errors import RunError

if TYPE_CHECKING:
    from mjxwalk.player.shown_walkers import ShownWalkers

MOST = 16  # walkers on a page; ours: what a phone draws smoothly
MAX_ROUGHNESS = 0.2  # m; ours: ten times the paper's roughest, a stair of a fifth of a leg
MAX_SECONDS = 600.0  # ours: ten times the longest trial of an experiment
FILE = "watch.html"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Watch:
    """Write a page on which walkers walk, in 3D, with their angles, torques and forces.

    It shows the tournament's winner, else the champion, else the fittest so far. The page is one
    file, which needs no network.

    Attributes:
      source: folder of a run, finished or not, or a walker that ships with mjxwalk.
      generation: whose fittest walker to show; of --walkers, whose population.
      walkers: number of the fittest of a population to show side by side, at most 16.
      champions: number of generations whose fittest to show side by side, at most 16: how it
        learned.
      terrain_seed: of the random ground.
      roughness: step of the random ground, m.
      seconds: after which the recording ends.
      out: the page; RUN/watch.html of a run, NAME.html of the zoo.
      open: whether to open it in a browser.
      video: film of one walker to write in place of the page, .mp4 or .gif, drawn by MuJoCo.
      viewer: whether to show one walker in MuJoCo's own window in place of the page.
      trust: execute the code of the run, which somebody else wrote.
    """

    source: Source
    generation: int | None = None
    walkers: int | None = None
    champions: int | None = None
    terrain_seed: Seed = 0
    roughness: OptionalFloat = None
    seconds: float = 60.0
    out: OptionalFile = None
    open: bool = False
    video: OptionalFile = None
    viewer: bool = False
    trust: bool = False

    def run(self) -> int:
        """Writes the page, says where, and returns the exit code.

        Raises:
          RunError: an argument is wrong, or there is no such walker.
        """
        self._check()
        if self.video is not None or self.viewer:
            return self._draw()
        out = self.out or self._default()
        outputs.check(out)
        from mjxwalk import engines
        from mjxwalk.player import page, recording
        from mjxwalk.player.recording import Take

        engines.prepare()
        shown = self._on_ground(self._shown())
        show, series = recording.perform(
            shown, Take(terrain_seed=self.terrain_seed, seconds=self.seconds)
        )
        run = Path(self.source) if self._is_in_run() else None
        outputs.write(out, page.render(show, series).encode(), run=run)
        for walker in show.walkers:
            print(f"{walker.label}: {walker.figures.distance_m:.1f} m, {walker.why}")
        outputs.tell(out)
        if self.open:
            import webbrowser

            webbrowser.open(out.resolve().as_uri())
        return 0

    def _check(self) -> None:
        """Finds wrong arguments that can be found without the second that importing JAX takes."""
        from mjxwalk import walkers

        for flag in ("walkers", "champions"):
            value = getattr(self, flag)
            if value is not None and not 1 <= value <= MOST:
                raise RunError(f"--{flag} must be from 1 to {MOST}, got {value}")
        if self.walkers is not None and self.champions is not None:
            raise RunError("--walkers is of one generation, --champions of several; give one")
        if self.generation is not None and self.generation < 1:
            raise RunError(f"--generation must be at least 1, got {self.generation}")
        if self.generation is not None and self.champions is not None:
            raise RunError("--champions is of several generations; leave out --generation")
        if self.roughness is not None and not 0 <= self.roughness <= MAX_ROUGHNESS:
            raise RunError(f"--roughness must be from 0 to {MAX_ROUGHNESS} m, got {self.roughness}")
        if not (math.isfinite(self.seconds) and 0.1 <= self.seconds <= MAX_SECONDS):
            raise RunError(f"--seconds must be from 0.1 to {MAX_SECONDS:g}, got {self.seconds}")
        walkers.check(self.source, trust=self.trust)
        self._check_drawing()

    def _check_drawing(self) -> None:
        """Finds out before any work whether MuJoCo can draw, if it is to."""
        if self.video is None and not self.viewer:
            return
        from mjxwalk import video

        flag = "--viewer" if self.video is None else "--video"
        if self.walkers is not None or self.champions is not None:
            raise RunError(f"{flag} shows one walker; leave out --walkers and --champions")
        if self.out is not None or self.open:
            raise RunError(f"{flag} takes the place of the page; leave out --out and --open")
        if self.viewer:
            video.check_screen()
        if self.video is not None:
            video.check(self.video)

    def _draw(self) -> int:
        """Writes the film, opens the window, and returns the exit code."""
        import jax

        from mjxwalk import engines, video, walkers

        engines.prepare()
        shown = self._on_ground(self._shown())
        walkers.check_has_anatomy(self.source, shown.experiment)
        shot = video.Shot(
            experiment=shown.experiment,
            genotype=jax.tree.map(lambda leaf: leaf[0], shown.genotypes),
            terrain_seed=self.terrain_seed,
            seconds=self.seconds,
        )
        if self.video is not None:
            video.film(shot, self.video)
            outputs.tell(self.video)
        if self.viewer:
            video.view(shot)
        return 0

    def _is_in_run(self) -> bool:
        """Returns whether the page is one of the run's files, and not one that the user named."""
        from mjxwalk import walkers

        return self.out is None and not walkers.in_zoo(self.source)

    def _default(self) -> Path:
        from mjxwalk import walkers

        if walkers.in_zoo(self.source):
            return Path(f"{walkers.zoo_name(self.source)}.html")
        return Path(self.source) / FILE

    def _shown(self) -> "ShownWalkers":
        from mjxwalk.player import shown_walkers

        if self.champions is not None:
            return shown_walkers.champions(self.source, self.champions)
        if self.walkers is not None:
            return shown_walkers.population(self.source, self.walkers, self.generation)
        if self.generation is not None:
            return shown_walkers.fittest(self.source, self.generation)
        return shown_walkers.best(self.source)

    def _on_ground(self, shown: "ShownWalkers") -> "ShownWalkers":
        from mjxwalk.settings import override

        experiment = shown.experiment.as_tested()
        if self.roughness is not None:
            experiment = override(experiment, "env.terrain.roughness", str(self.roughness))
        return dataclasses.replace(shown, experiment=experiment)
