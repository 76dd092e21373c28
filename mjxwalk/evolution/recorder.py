"""What keeps a run as it evolves: in its folder, or not at all."""

from pathlib import Path

from mjxwalk.evolution.champions import Choice
from mjxwalk.evolution.generation import RunState
from mjxwalk.experiments.run_config import Config
from mjxwalk.fitting import Fitting
from mjxwalk.progress import Reporter
from mjxwalk.runs import Metrics, Result, RunError, config, folder, metrics, result
from mjxwalk.runs.checkpoints import Checkpoints, generations, restore_newest
from mjxwalk.runs.trees import flatten, unflatten


class Recorder:
    """Keeps a run as it evolves; this one keeps nothing, since another process writes the run."""

    def __init__(self) -> None:
        self._generation = 0

    def restore(self, start: RunState) -> RunState:
        """Returns the state to go on from: the newest that was kept, or else the start."""
        return start

    def record(self, state: RunState, line: Metrics) -> None:
        """Keeps a generation and its figures."""
        self._generation = int(state.generation)

    def complete(self) -> None:
        """Is called after the last generation, before the champion is chosen."""

    def finish(self, choice: Choice) -> None:
        """Keeps the champion."""

    def stop(self) -> int:
        """Keeps what was recorded, as the run is interrupted, and returns its last generation."""
        return self._generation


class RunRecorder(Recorder):
    """Writes a run in its folder, and tells a reporter of each generation.

    Use it as a context manager, which waits for what is being written.
    """

    def __init__(self, path: Path, settings: Config, reporter: Reporter) -> None:
        """Args: path: of the folder, made and locked by the caller. settings: in `config.json`."""
        self._path = path
        self._settings = settings
        self._reporter = reporter
        self._folder = path / folder.CHECKPOINTS
        self._checkpoints = Checkpoints(self._folder, keep=settings.keep, before=(metrics.FILE,))
        self._state: RunState | None = None  # recorded last

    def __enter__(self) -> "RunRecorder":
        return self

    def __exit__(self, *args: object) -> None:
        self._checkpoints.__exit__(*args)

    def restore(self, start: RunState) -> RunState:
        """Returns the state to go on from, and cuts the figures of generations that are lost.

        Raises:
          RunError: no checkpoint can be read where there should be one, or it is of another
            experiment.
        """
        lines = metrics.read(self._path)
        generation, arrays, damaged = restore_newest(self._folder, up_to=len(lines))
        for reason in damaged.values():
            self._reporter.say(reason)
        if generation == 0:
            self._check_nothing_lost(len(lines), is_damaged=bool(damaged))
            state = start
        else:
            which = ", the newest that is whole" if damaged else ""
            self._reporter.say(f"going on from generation {generation}{which}")
            try:
                state = unflatten(start, arrays)
            except RunError as error:
                raise RunError(
                    f"checkpoint {generation} of {self._path} is of another experiment: {error}"
                ) from None
        metrics.cut(self._path, generation)
        self._checkpoints.discard_after(generation)
        self._state = state
        return state

    def _check_nothing_lost(self, num_lines: int, *, is_damaged: bool) -> None:
        """Raises RunError if a run had saved something, and nothing of it can be read."""
        # Killed before its first checkpoint was whole, a run has nothing to lose.
        if is_damaged or num_lines > 2 * self._settings.save_every:
            raise RunError(
                f"no checkpoint of {self._path} can be read, so it cannot be resumed; evolve it "
                f"again with its settings in {self._path / config.FILE}"
            )
        if generations(self._folder):
            raise RunError(
                f"{self._path / metrics.FILE} ends after generation {num_lines}, before the oldest "
                "checkpoint: it was cut or changed; put it back as it was, or remove "
                f"{self._folder} to evolve from generation 1 again"
            )

    def record(self, state: RunState, line: Metrics) -> None:
        """Adds the generation's line, then starts saving it: a checkpoint never lacks its line.

        Raises:
          RunError: the line cannot be written, or the checkpoint before could not be saved.
        """
        metrics.append(self._path, line)
        if line.generation % self._settings.save_every == 0:
            self._checkpoints.save(line.generation, flatten(state))
        self._state = state
        self._reporter.generation(line)

    def complete(self) -> None:
        """Saves the last generation, and says that the champion is being chosen.

        Raises:
          RunError: it could not be saved.
        """
        self.stop()
        if not isinstance(self._settings.experiment, Fitting):
            self._reporter.say("choosing the champion on new terrains")

    def finish(self, choice: Choice) -> None:
        """Writes the champion, and what the run took.

        Raises:
          RunError: a file cannot be written.
        """
        lines = metrics.read(self._path)
        outcome = Result(
            champion=choice.champion,
            generations=len(lines),
            wall_s=sum(line.wall_s for line in lines),
            physics_steps=sum(line.physics_steps for line in lines),
        )
        result.write(self._path, outcome, flatten(choice.genotype))

    def stop(self) -> int:
        """Saves what was recorded last, unless it is saved, and returns its generation.

        Raises:
          RunError: it could not be saved.
        """
        generation = 0 if self._state is None else int(self._state.generation)
        if generation > 0:
            self._checkpoints.save(generation, flatten(self._state))
        self._checkpoints.wait()
        return generation
