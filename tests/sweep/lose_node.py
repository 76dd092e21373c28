"""Runs a sweep of six runs on a Ray cluster of two local nodes, and kills one on the way.

python tests/sweep/lose_node.py FOLDER
"""

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from mjxwalk.runs import metrics


def main(folder: Path) -> int:
    """Returns the exit code of the sweep."""
    from ray.cluster_utils import Cluster  # pyright: ignore

    cluster: Any = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    lost: Any = cluster.add_node(num_cpus=1)
    cluster.wait_for_nodes()
    command = [
        *[sys.executable, "-m", "mjxwalk", "sweep", "planar-lpd", "--seeds", "6"],
        *["--generations", "12", "--population", "64", "--out", str(folder)],
        *["--executor", "ray", "--address", cluster.address],
    ]
    sweep = subprocess.Popen(command)
    while sum(len(metrics.read(each)) > 1 for each in folder.glob("seed-*")) < 2:
        if sweep.poll() is not None:
            return sweep.returncode
        time.sleep(0.2)
    cluster.remove_node(lost, allow_graceful=False)
    print("one node of two was killed while both had a run", flush=True)
    return sweep.wait()


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
