"""Runs of a sweep as tasks of a Ray cluster; its machines must share the sweep's disk."""

import importlib
import os
from typing import Any

from mjxwalk.errors import RunError
from mjxwalk.sweep.executors import GIGABYTE, Job
from mjxwalk.sweep.plan import Resources
from mjxwalk.sweep.worker import work

RETRIES = 10  # ours: machines that a run may lose before it counts as failed


class OnRay:
    """The tasks of one sweep.

    Attributes:
      slots: runs at a time; those that do not fit wait in the cluster.
      where: in words.
    """

    def __init__(self, resources: Resources) -> None:
        try:
            ray = importlib.import_module("ray")  # an extra, which may not be there
        except ImportError:
            raise RunError(
                "--executor ray needs Ray, which is not installed; pip install 'mjxwalk[ray]'"
            ) from None
        self._ray: Any = ray  # its own types are partly unknown
        try:
            self._ray.init(address=resources.address or "auto", log_to_driver=False)
        except Exception as error:  # Ray raises its own, and those of its network
            reason = str(error).strip().splitlines() or [type(error).__name__]
            raise RunError(
                f"no Ray cluster answers at {resources.address or 'auto'} ({reason[0]}); start one "
                "with `ray start --head`, or name one with --address"
            ) from None
        cores = resources.cores or 1
        options: dict[str, Any] = {
            "num_cpus": cores,
            "max_retries": RETRIES,
            "max_calls": 1,  # a process for each run: JAX keeps what it has taken
        }
        if resources.memory_gb is not None:
            options["memory"] = int(resources.memory_gb * GIGABYTE)
        self._work = self._ray.remote(**options)(_in_folder)
        self._cores, self._memory_gb = cores, resources.memory_gb
        lent = int(self._ray.cluster_resources().get("CPU", 0))
        self.slots = max(1, lent // cores)
        self.where = f"on a Ray cluster with {lent} cores, {cores} each"

    def start(self, job: Job) -> "_Task":
        """Has the cluster run a job when it has the room."""
        reference = self._work.remote(
            os.getcwd(), job.args, str(job.path), str(job.log), self._cores, self._memory_gb
        )
        return _Task(self._ray, reference)

    def close(self) -> None:
        """Leaves the cluster."""
        self._ray.shutdown()


def _in_folder(
    folder: str, args: tuple[str, ...], path: str, log: str, cores: int, memory_gb: float | None
) -> int:
    os.chdir(folder)
    return work(args, path, log, cores, memory_gb)


class _Task:
    def __init__(self, ray: Any, reference: Any) -> None:
        self._ray = ray
        self._reference = reference

    def is_done(self) -> bool:
        done, _ = self._ray.wait([self._reference], timeout=0)
        return bool(done)

    def stop(self) -> None:
        self._ray.cancel(self._reference)  # raises KeyboardInterrupt in it
