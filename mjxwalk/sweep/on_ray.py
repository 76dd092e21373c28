"""Runs of a sweep as tasks of a Ray cluster; its machines must share the sweep's disk."""

import importlib
import os
import subprocess
import sys
from typing import Any

from mjxwalk import installing
from mjxwalk.errors import RunError, first_line
from mjxwalk.sweep.jobs import GIGABYTE, Job, Main
from mjxwalk.sweep.plan import Resources
from mjxwalk.sweep.worker import work

WAITING = 20.0  # s for a cluster to answer; ours: one that is there takes one or two
TRY = "import ray, sys; ray.init(address=sys.argv[1], log_to_driver=False)"
RETRIES = 10  # ours: machines that a run may lose before it counts as failed


class OnRay:
    """The tasks of one sweep.

    Attributes:
      slots: runs at a time; those that do not fit wait in the cluster.
      where: in words.
    """

    def __init__(self, resources: Resources, main: Main) -> None:
        try:
            ray = importlib.import_module("ray")  # an extra, which may not be there
        except ImportError:
            raise RunError(
                "--executor ray needs Ray, which is not installed; add it with: "
                f"{installing.of_extra('ray')}"
            ) from None
        self._ray: Any = ray  # its own types are partly unknown
        address = resources.address or "auto"
        _check_answers(address)
        try:
            self._ray.init(address=address, log_to_driver=False)
        except Exception as error:  # Ray raises its own, and those of its network
            raise _no_cluster(address, first_line(error)) from None
        cores = resources.cores or 1
        self._check_room(cores, resources.memory_gb)
        options: dict[str, Any] = {
            "num_cpus": cores,
            "max_retries": RETRIES,
            "max_calls": 1,  # a process for each run: JAX keeps what it has taken
        }
        if resources.memory_gb is not None:
            options["memory"] = int(resources.memory_gb * GIGABYTE)
        self._work = self._ray.remote(**options)(_in_folder)
        self._main, self._cores, self._memory_gb = main, cores, resources.memory_gb
        lent = int(self._ray.cluster_resources().get("CPU", 0))
        self.slots = max(1, lent // cores)
        self.where = f"on a Ray cluster with {lent} cores, {cores} each"

    def _check_room(self, cores: int, memory_gb: float | None) -> None:
        """Raises RunError unless a machine of the cluster is large enough; Ray would just wait."""
        lent = [node["Resources"] for node in self._ray.nodes() if node["Alive"]]
        needed = (memory_gb or 0.0) * GIGABYTE
        if not any(o.get("CPU", 0) >= cores and o.get("memory", 0) >= needed for o in lent):
            self.close()
            memory = "" if memory_gb is None else f" and {memory_gb:g} GB"
            raise RunError(
                f"no machine of the Ray cluster has {cores} cores{memory} for a run; ask for less "
                "by --cores-per-run and --memory-per-run"
            )

    def start(self, job: Job) -> "_Task":
        """Has the cluster run a job when it has the room."""
        reference = self._work.remote(
            os.getcwd(),
            self._main,
            job.args,
            str(job.path),
            str(job.log),
            self._cores,
            self._memory_gb,
        )
        return _Task(self._ray, reference)

    def close(self) -> None:
        """Leaves the cluster."""
        self._ray.shutdown()


def _check_answers(address: str) -> None:
    """Raises RunError if no cluster answers soon: Ray itself would try for minutes without a word.

    That is tried in a process of its own, since nothing ends such a try.
    """
    if address == "local":  # one that Ray starts itself
        return
    command = [sys.executable, "-c", TRY, address]
    try:
        tried = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=WAITING)
    except subprocess.TimeoutExpired:
        raise _no_cluster(address, f"no answer in {WAITING:.0f} s") from None
    if tried.returncode:
        lines = tried.stderr.strip().splitlines()
        raise _no_cluster(address, lines[-1] if lines else f"exit code {tried.returncode}")


def _no_cluster(address: str, reason: str) -> RunError:
    return RunError(
        f"no Ray cluster answers at {address} ({reason}); start one with `ray start --head`, or "
        "name one with --address"
    )


def _in_folder(folder: str, *job: Any) -> int:
    """Works in a folder, as `work` does."""
    os.chdir(folder)
    return work(*job)


class _Task:
    def __init__(self, ray: Any, reference: Any) -> None:
        self._ray = ray
        self._reference = reference

    def is_done(self) -> bool:
        try:
            done, _ = self._ray.wait([self._reference], timeout=0)
        except Exception as error:  # Ray raises its own
            raise RunError(f"the Ray cluster has gone ({first_line(error)})") from None
        return bool(done)

    def reason(self) -> str | None:
        try:
            self._ray.get(self._reference)
        except Exception as error:  # of the worker, or what it raised
            return first_line(getattr(error, "cause", None) or error)
        return None

    def stop(self) -> None:
        self._ray.cancel(self._reference)  # raises KeyboardInterrupt in it
