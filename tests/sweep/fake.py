"""Stands in for `mjxwalk` in a sweep: makes and resumes runs that evolve nothing, in no time."""

import json
import os
import resource
import signal
import sys
import time
from pathlib import Path
from typing import Any

from mjxwalk.runs import Champion, Result, config, digests, folder, metrics, result

GENERATIONS = 3


def main(args: list[str]) -> int:
    """Evolves nothing.

    For a sigma of 13 it fails unless a file named `mended` is there, for 9 it is killed, and for 20
    it takes a minute.
    """
    resumed = args[0] == "resume"
    path = Path(args[1] if resumed else args[args.index("--out") + 1])
    fails = any("sigma=13" in arg for arg in args) or (path / "fails").exists()
    slow = any("sigma=20" in arg for arg in args)
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
    told = {
        "args": args,
        "cores": cores,
        "threads": os.environ.get("MJXWALK_LANES_THREADS"),
        "memory": resource.getrlimit(resource.RLIMIT_DATA)[0],
    }
    print(json.dumps(told), flush=True)
    if any("sigma=9" in arg for arg in args):
        os.kill(os.getpid(), signal.SIGKILL)
    path.mkdir(exist_ok=True)
    with folder.locked(path):
        if not resumed:
            experiment: dict[str, Any] = {"name": "toy", "generations": GENERATIONS}
            data = {
                "schema": config.SCHEMA, "seed": 0, "engine": "mjx", "keep": 1, "save_every": 1,
                "origin": None, "experiment": experiment,
            }  # fmt: skip
            (path / config.FILE).write_bytes(digests.with_digest(data))
        for generation in range(1, GENERATIONS + 1):
            metrics.append(path, _line(generation))
            time.sleep(20 if slow else 0.01)
        if fails and not Path("mended").exists():
            (path / "fails").touch()
            print("mjxwalk: the friction is too slippery", file=sys.stderr)
            return 2
        champion = Champion(
            generation=1, distance_m=2.5, fall_rate=0.0, speed_m_s=None, cost_of_transport=None,
            terrains=1,
        )  # fmt: skip
        result.write(path, Result(champion=champion, generations=3, wall_s=1, physics_steps=1), {})
    return 0


def _line(generation: int) -> metrics.Metrics:
    unknown: dict[str, Any] = dict.fromkeys(metrics.Metrics.__struct_fields__, 0.5)
    whole: dict[str, Any] = {"generation": generation, "physics_steps": 10, "strategy": {}}
    return metrics.Metrics(**(unknown | whole))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
