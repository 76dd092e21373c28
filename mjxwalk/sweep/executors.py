"""Which executor takes the jobs of a sweep."""

from pathlib import Path

from mjxwalk.sweep.jobs import Executor, Main
from mjxwalk.sweep.local import Local
from mjxwalk.sweep.on_ray import OnRay
from mjxwalk.sweep.on_slurm import OnSlurm
from mjxwalk.sweep.plan import Resources


def make(resources: Resources, num_runs: int, folder: Path, main: Main) -> Executor:
    """Returns the executor that was asked for.

    Args:
      resources: that were asked for.
      num_runs: that it will start.
      folder: of the sweep.
      main: runs a command of mjxwalk in the process of a cluster, and returns its exit code.

    Raises:
      RunError: it is not installed, not there, or too small for one run.
    """
    if resources.executor == "ray":
        return OnRay(resources, main)
    if resources.executor == "slurm":
        return OnSlurm(resources, folder, main)
    return Local(resources, num_runs)
