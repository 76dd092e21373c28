"""Runs of a sweep as jobs of Slurm, by submitit; its machines must share the sweep's disk."""

import importlib
import shutil
from pathlib import Path
from typing import Any

from mjxwalk import installing
from mjxwalk.errors import RunError, first_line
from mjxwalk.sweep.jobs import Job, Main
from mjxwalk.sweep.plan import Resources
from mjxwalk.sweep.worker import work

FOLDER = "slurm"  # in the sweep's: submitit's own, which nothing of ours reads
MOST_JOBS = 1000  # ours: waiting at a time; a queue of Slurm has a limit


class OnSlurm:
    """The jobs of one sweep.

    Attributes:
      slots: jobs that wait or run at a time.
      where: in words.
    """

    slots = MOST_JOBS

    def __init__(
        self,
        resources: Resources,
        folder: Path,
        main: Main,
        cluster: str = "slurm",
    ) -> None:
        try:
            submitit = importlib.import_module("submitit")  # an extra
        except ImportError:
            raise RunError(
                "--executor slurm needs submitit, which is not installed; add it with: "
                f"{installing.of_extra('slurm')}"
            ) from None
        if cluster == "slurm" and shutil.which("sbatch") is None:
            raise RunError("there is no `sbatch` here; give the command where jobs are submitted")
        self._main = main
        self._cores, self._memory_gb = resources.cores or 1, resources.memory_gb
        parameters: dict[str, Any] = {
            "cpus_per_task": self._cores,
            "timeout_min": max(1, round(60 * resources.hours)),
            "name": "mjxwalk",
        }
        if resources.memory_gb is not None:
            parameters["mem_gb"] = resources.memory_gb
        if resources.partition is not None and cluster == "slurm":
            parameters["slurm_partition"] = resources.partition
        try:
            self._executor: Any = submitit.AutoExecutor(folder=folder / FOLDER, cluster=cluster)
            self._executor.update_parameters(**parameters)
        except (RuntimeError, ValueError, OSError) as error:
            raise RunError(
                f"Slurm cannot be used from here ({first_line(error)}); run this where `sbatch` is"
            ) from None
        self.where = f"as jobs of Slurm, {self._cores} cores each"

    def start(self, job: Job) -> "_Submitted":
        """Submits a job.

        Raises:
          RunError: Slurm refuses it.
        """
        path, log = str(job.path.resolve()), str(job.log.resolve())
        work_again = Resumable(self._main, job.args, path, log)
        try:
            return _Submitted(self._executor.submit(work_again, self._cores, self._memory_gb))
        except Exception as error:  # submitit raises its own, and those of `sbatch`
            raise RunError(f"Slurm did not take it ({first_line(error)})") from None

    def close(self) -> None:
        """Has nothing to let go of: jobs that wait were cancelled."""


class Resumable:
    """A run's work, which Slurm may cut short and start again."""

    def __init__(self, main: Main, args: tuple[str, ...], path: str, log: str) -> None:
        self._job = main, args, path, log

    def __call__(self, cores: int, memory_gb: float | None) -> int:
        """Works on the run, and returns the exit code."""
        return work(*self._job, cores, memory_gb)

    def checkpoint(self, cores: int, memory_gb: float | None) -> Any:
        """Returns what submitit is to submit once the job's time is up: the run goes on."""
        submitit = importlib.import_module("submitit")
        return submitit.helpers.DelayedSubmission(self, cores, memory_gb)


class _Submitted:
    def __init__(self, job: Any) -> None:
        self._job = job

    def is_done(self) -> bool:
        return bool(self._job.done())

    def reason(self) -> str | None:
        error = self._job.exception()
        return None if error is None else first_line(error)

    def stop(self) -> None:
        self._job.cancel()
