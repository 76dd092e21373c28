"""What has to be measured in a fresh process: compiling, and the peak memory of a population.

`python -m mjxwalk.bench.child compile h1` prints one line of JSON.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

from mjxwalk import own_process
from mjxwalk.errors import RunError

MEMORY_STEPS = 100  # ours: memory is taken at the start


class Compiling(NamedTuple):
    """What compiling a body takes.

    Attributes:
      cold: seconds with an empty disk cache.
      warm: seconds with a full one.
      code_bytes: of the machine code.
    """

    cold: float
    warm: float
    code_bytes: int


def compiling(body: str, *, file_options: bool = False) -> Compiling:
    """Returns what compiling a body's trial takes, in fresh processes."""
    with tempfile.TemporaryDirectory() as folder:
        args = ["compile", body, *(["file-options"] if file_options else [])]
        cold, warm = (_ask(args, cache=folder) for _ in range(2))
    return Compiling(cold["seconds"], warm["seconds"], cold["code_bytes"])


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


def _compile(name: str, *options: str) -> dict[str, Any]:
    from mjxwalk.bench import bodies
    from mjxwalk.bench.contact_bodies import WALKED
    from mjxwalk.engines import lanes
    from mjxwalk.evaluation import OUTCOME

    body = bodies.get(name, file_options="file-options" in options)
    workload = body.workload(1)
    arguments = workload.genotypes, workload.given
    if isinstance(body, bodies.PointBody):
        mapped = lanes.vmap(body.study().rollout, workload.axes, results=OUTCOME)
    else:
        import numpy as np  # late, as the program's own process declares itself before

        mapped = lanes.vmap(body.walk, (*workload.axes, None), results=WALKED)
        arguments += (np.int32(1),)
    started = time.perf_counter()
    mapped.prepare(*arguments)
    return {"seconds": time.perf_counter() - started, "code_bytes": _code_bytes()}


def _code_bytes() -> int:
    """Returns how large the machine code is that lies in the cache."""
    from llvmlite.binding.object_file import ObjectFileRef

    from mjxwalk import cache_folder
    from mjxwalk.engines.lanes.cache import entries

    total, folder = 0, cache_folder.folder("lanes")
    for path in [] if folder is None else sorted(folder.iterdir()):
        entry = entries.read(path.name)
        if entry is not None and entry[1]:
            parts: Any = ObjectFileRef.from_data(entry[1]).sections()
            total += sum(part.size() for part in parts if part.is_text())
    return total


def _memory(body: str, size: str) -> dict[str, Any]:
    from mjxwalk.bench import bodies, contenders
    from mjxwalk.engines import lanes

    def walk(size: int) -> None:
        contenders.Engine(lanes.vmap, bodies.get(body).workload(size))(MEMORY_STEPS)

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
