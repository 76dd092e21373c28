"""What has to be measured in a fresh process: compiling, and the peak memory of a population.

`python -m mjxwalk.bench.child compile planar` prints one line of JSON.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from mjxwalk import own_process
from mjxwalk.errors import RunError

MEMORY_STEPS = 100  # ours: memory is taken at the start


def compile_seconds(body: str) -> tuple[float, float]:
    """Returns seconds to compile a body's rollout with an empty disk cache, and with a full one."""
    with tempfile.TemporaryDirectory() as folder:
        cold, warm = (_ask(["compile", body], cache=folder) for _ in range(2))
    return cold["seconds"], warm["seconds"]


def peak_memory(body: str, size: int) -> dict[str, int]:
    """Returns a process's peak memory in bytes, `before` and `after` a population walks."""
    return _ask(["memory", body, str(size)])


def _ask(args: list[str], cache: str | None = None) -> dict[str, Any]:
    """Returns what this module prints in a process of its own.

    Args:
      args: of the process.
      cache: folder that serves as the user's cache; None for the real one.
    """
    env = dict(os.environ)
    if cache is not None:
        env["XDG_CACHE_HOME"] = cache
        env.pop("JAX_COMPILATION_CACHE_DIR", None)
    command = [sys.executable, "-m", "mjxwalk.bench.child", *args]
    done = subprocess.run(command, env=env, capture_output=True, encoding="utf-8", errors="replace")
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["it said nothing"])[-1]
        raise RunError(f"`mjxwalk.bench.child {' '.join(args)}` failed: {last}")
    return json.loads(done.stdout.splitlines()[-1])


def _compile(body: str) -> dict[str, Any]:
    from mjxwalk.bench import bodies
    from mjxwalk.engines import lanes
    from mjxwalk.evaluation import OUTCOME

    workload = bodies.workload(bodies.BODIES[body], 1)
    mapped = lanes.vmap(bodies.BODIES[body].study().rollout, workload.axes, results=OUTCOME)
    started = time.perf_counter()
    mapped.prepare(workload.genotypes, workload.given)
    return {"seconds": time.perf_counter() - started}


def _memory(body: str, size: str) -> dict[str, Any]:
    from mjxwalk.bench import bodies, contenders
    from mjxwalk.engines import lanes

    def walk(size: int) -> None:
        workload = bodies.workload(bodies.BODIES[body], size)
        contenders.Engine(lanes.vmap, workload)(MEMORY_STEPS)

    walk(1)
    before = peak_bytes()
    walk(int(size))
    return {"before": before, "after": peak_bytes()}


def peak_bytes() -> int:
    """Returns the most memory that this process has held."""
    status = Path("/proc/self/status")
    if status.exists():
        # `getrusage` would start from what the parent held when it forked.
        found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text(encoding="utf-8"))
        if found:
            return 1024 * int(found[1])
    try:
        import resource
    except ImportError:  # Windows does not tell
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


def main(args: list[str]) -> None:
    """Measures and prints one line of JSON."""
    from mjxwalk import engines

    engines.prepare()
    ask = {"compile": _compile, "memory": _memory}[args[0]]
    print(json.dumps(ask(*args[1:])))


if __name__ == "__main__":
    own_process.declare()
    main(sys.argv[1:])
