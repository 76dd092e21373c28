"""`mjxwalk evolve` and `mjxwalk resume`."""

import dataclasses
import functools
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from mjxwalk import experiments, shell
from mjxwalk.cli.argument_types import RunFolder
from mjxwalk.cli.evolve_arguments import EvolveArguments, Together
from mjxwalk.cli.following import Following
from mjxwalk.errors import Interrupted, RunError
from mjxwalk.experiments import own_task

if TYPE_CHECKING:
    from mjxwalk.evolution.runner import Runner

Job = Callable[["Runner"], None]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Evolve(EvolveArguments):
    """Evolve walkers, in a folder of their own."""

    def run(self) -> int:
        """Evolves and returns the exit code.

        Raises:
          RunError: an argument is wrong, or the run cannot go on.
        """
        self.check()
        from mjxwalk.runs import folder

        path = self.out or folder.default_path(self.title, self.seed)
        if not self.distributed:  # the first of several processes may have made it by now
            folder.check_free(path)
        is_study = self.experiment in experiments.studies()
        job = self._evolve_study if is_study else self._evolve_run
        return _work(path, functools.partial(job, path), self)

    def _evolve_run(self, path: Path, runner: "Runner") -> None:
        from mjxwalk.cli.choosing import choose_run

        runner.evolve_run(path, *choose_run(self))

    def _evolve_study(self, path: Path, runner: "Runner") -> None:
        from mjxwalk.cli.choosing import choose_study

        runner.evolve_study(path, choose_study(self))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Resume(Together, Following):
    """Go on with what was stopped, killed or out of disk, to the same bits.

    Attributes:
      run_folder: folder of a run, a study or a sweep.
      trust: execute the code in the folder, which somebody else wrote.
    """

    run_folder: RunFolder
    trust: bool = False

    def run(self) -> int:
        """Goes on with the run and returns the exit code.

        Raises:
          RunError: the folder is no run, or the run cannot go on.
        """
        from mjxwalk.runs import folder, study
        from mjxwalk.sweep import plan

        self.check_following()
        self.check_together()
        path = self.run_folder
        if plan.is_sweep(path):
            from mjxwalk.cli import sweep, sweep_grid

            self._check_sweep(path)
            planned = plan.read(path, sweep_grid.is_of_sweep)
            sweep_grid.check_trust(path, planned, is_given=self.trust)
            return sweep.go_on(path, planned)
        is_study = study.is_study(path)
        if not is_study:
            folder.check_run(path)
            own_task.trust.check_run(path, is_given=self.trust)
        elif self.distributed:
            raise RunError(f"{path} is a study; --distributed is for a run")

        def job(runner: "Runner") -> None:
            if is_study:
                runner.resume_study(path)
            else:
                runner.resume_run(path)

        return _work(path, job, self)

    def _check_sweep(self, path: Path) -> None:
        for flag in ("distributed", "live", "tensorboard"):
            if getattr(self, flag):
                raise RunError(
                    f"{path} is a sweep, whose runs go on as they were begun; --{flag} is for one "
                    "run"
                )


def _work(path: Path, job: Job, together: Evolve | Resume) -> int:
    """Does what takes long in a terminal, and says how to go on if it is stopped."""
    from mjxwalk.cli.interrupt import Interrupt
    from mjxwalk.cli.progress import make_progress

    progress = together.followed(make_progress())
    # Of several processes one must not leave a generation that the others are in.
    with Interrupt(progress.say, is_raised=not together.distributed) as interrupt:
        try:
            from mjxwalk import engines
            from mjxwalk.evolution.runner import Runner

            engines.prepare()
            processes = together.join()
            job(Runner(progress=progress, stopping=interrupt.requested, processes=processes))
            return 0
        except RunError as error:
            if not together.distributed:
                raise
            # At once: JAX would wait for processes that are gone, and then end this one with noise.
            progress.close()
            print(f"mjxwalk: {' '.join(str(error).split())}", file=sys.stderr, flush=True)
            os._exit(2)
        except Interrupted as stop:
            progress.close()
            progress.say(f"{stop}; go on with: {shell.command('resume', path)}")
        except KeyboardInterrupt:
            progress.close()
            begun = any((path / name).exists() for name in ("config.json", "study.json"))
            go_on = f"; go on with: {shell.command('resume', path)}" if begun else ""
            progress.say(f"stopped{go_on}")
    return 128 + interrupt.signal
