"""Checks on a machine with an NVIDIA GPU that rollouts run there, and how fast.

    timeout 600 python scripts/gpu_check.py --out gpu_check.json

First a short rollout by each engine on the GPU is compared with JAX's on the CPU. Then `mjx`,
`lanes-xla` and the PTX kernel of `mjxwalk.engines.lanes_ptx` walk in turn, beside `lanes` on the
CPU. The file is written anew after each part, so that an end by force leaves what was measured.
"""

import dataclasses
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mjxwalk import cli, outputs
from mjxwalk.errors import RunError

SHORT = 0.1  # s of a trial that is compared: contact's chaos takes longer to make rounding seen
COMPARED = 256  # walkers
# What is rounding in nearly all walkers; chaos takes hold of a few even in so short a trial.
DISTANCE = 2e-5  # m
WORK = 2e-3  # of a walker's work, or of the mean if that is more
ENOUGH = 0.95  # of all walkers
REPEATS = 5  # of a timing
TIMED = 0.5  # s of a timing
RESERVE = 60.0  # s that a part may take: compiling, mostly; none is begun with less left


@dataclasses.dataclass(frozen=True, kw_only=True)
class GpuCheck:
    """Check rollouts on an NVIDIA GPU, and measure them.

    Attributes:
      out: JSON file to write; an old one is replaced.
      body: name of a body of `mjxwalk bench` under our contact points.
      populations: sizes to measure.
      minutes: after which no further part begins.
    """

    out: Path = Path("gpu_check.json")
    body: str = "planar7-points"
    populations: tuple[int, ...] = (4_096, 65_536)
    minutes: float = 9.0

    def run(self) -> int:
        """Returns 0 where all is well and 1 where an engine failed or differs.

        Raises:
          RunError: an argument is wrong, or there is no GPU.
        """
        started = time.monotonic()
        if not self.populations or min(self.populations) < 1:
            raise RunError(f"--populations must be at least 1, got {self.populations}")
        outputs.check(self.out)
        # Of the GPU's memory JAX would take three quarters at once.
        os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
        from mjxwalk import engines

        engines.prepare()
        found: dict[str, Any] = {"gpu": gpu(), "body": self.body, "smoke": {}, "speed": []}

        def keep() -> None:
            found["seconds"] = time.monotonic() - started
            outputs.write(self.out, outputs.as_json(found))

        for name, vmap in contenders().items():
            found["smoke"][name] = said = attempt(lambda vmap=vmap: smoke(vmap))
            print(f"smoke, {name}: {said}", flush=True)
            keep()
        for size in self.populations:
            if time.monotonic() - started > 60 * self.minutes - RESERVE:
                print(f"{size:,} walkers are left out, as the time is up")
                break
            left = 60 * self.minutes - RESERVE + started
            found["speed"].append(speed(self.body, size, contenders(), left))
            print(found["speed"][-1], flush=True)
            keep()
        print(f"wrote {self.out}")
        well = [said.get("agrees", False) for said in found["smoke"].values()]
        failed = any("error" in each for row in found["speed"] for each in row["engines"].values())
        return 0 if all(well) and not failed else 1


def gpu() -> dict[str, Any]:
    """Returns what the GPU is.

    Raises:
      RunError: there is none.
    """
    import jax

    from mjxwalk.engines import cuda_driver

    try:
        device = cuda_driver.Device()
        theirs = jax.devices("gpu")
    except cuda_driver.CudaError as error:
        raise RunError(f"there is no GPU to check: {error}") from error
    except RuntimeError as error:
        raise RunError(
            "JAX does not see the GPU: install the extra cuda of mjxwalk, and leave JAX_PLATFORMS "
            "unset or name cuda first and cpu after it"
        ) from error
    if jax.default_backend() != "gpu":
        raise RunError("JAX sees the GPU and uses the CPU: leave JAX_PLATFORMS unset")
    return {
        "name": device.name,
        "capability": device.capability,
        "multiprocessors": device.multiprocessors,
        "devices": len(theirs),
        "jax": jax.__version__,
    }


def contenders() -> dict[str, Callable[..., Any]]:
    """Returns the `vmap` of every engine that has the GPU, and of lanes, which has not."""
    from mjxwalk.engines import lanes, lanes_ptx, lanes_xla, mjx

    return {
        "ptx": lanes_ptx.vmap,
        "lanes-xla": lanes_xla.vmap,
        "mjx": mjx.vmap,
        "lanes": lanes.vmap,
    }


def attempt(part: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Returns what a part finds, or what went wrong, since the other parts are worth having."""
    started = time.monotonic()
    try:
        found = part()
    except Exception as error:
        found = {"error": f"{type(error).__name__}: {error}"[:2_000]}
    return found | {"seconds": time.monotonic() - started}


def smoke(vmap: Callable[..., Any]) -> dict[str, Any]:
    """Returns how an engine's rollouts of short trials differ from those of JAX on the CPU."""
    import jax
    import numpy as np

    from mjxwalk import experiments
    from mjxwalk.bench import bodies
    from mjxwalk.envs import TRIAL_AXES

    experiment = experiments.get("planar-lpd")
    short = dataclasses.replace(experiment.env, max_time=SHORT)
    experiment = dataclasses.replace(experiment, env=short)
    genotypes = bodies.get("planar7-points").workload(COMPARED).genotypes
    trials = experiment.sample_trials(jax.random.key(0), 1).given(np.zeros(COMPARED, np.int32))
    axes = (0, TRIAL_AXES)
    given = jax.tree.map(np.asarray, (genotypes, trials))
    ours = jax.block_until_ready(vmap(experiment.rollout, axes)(*given))
    with jax.default_device(jax.devices("cpu")[0]):
        theirs = jax.jit(jax.vmap(experiment.rollout, axes))(*given)
    return difference(ours, theirs)


def difference(ours: Any, theirs: Any) -> dict[str, Any]:
    """Returns how far outcomes are apart, and whether nearly all are by rounding; NaN is apart."""
    import numpy as np

    def both(name: str) -> tuple[Any, Any]:
        one, other = (np.asarray(getattr(each, name), np.float64) for each in (ours, theirs))
        return np.abs(one - other), np.abs(other)

    (far, _), (work, size), (fell, _) = both("distance"), both("work"), both("fell")
    share = work / np.maximum(size, np.mean(size))
    close = (far <= DISTANCE) & (share <= WORK) & (fell == 0)
    return {
        "agrees": bool(close.mean() >= ENOUGH),
        "close": float(close.mean()),
        "distance_m": float(np.max(far)),
        "work_share": float(np.max(share)),
        "falls_that_differ": int(fell.sum()),
    }


def speed(
    body: str, size: int, engines: dict[str, Callable[..., Any]], latest: float
) -> dict[str, Any]:
    """Returns the steps a second of each engine, medians of timings in turn.

    Args:
      latest: reading of the monotonic clock after which no further engine is compiled.
    """
    from mjxwalk.bench import bodies, timing
    from mjxwalk.bench.contenders import Engine

    load = bodies.get(body).workload(size)
    rows: dict[str, dict[str, Any]] = {}
    ready: dict[str, tuple[Engine, int]] = {}

    def prepared(name: str, vmap: Callable[..., Any]) -> dict[str, Any]:
        engine = Engine(vmap, load)
        ready[name] = engine, timing.calibrate(engine, TIMED)
        kernel: Any = getattr(engine.mapped, "kernel", None)
        if kernel is None:
            return {}
        return {"registers": kernel.registers, "local_bytes": kernel.local_bytes}

    for name, vmap in engines.items():
        if time.monotonic() > latest:
            rows[name] = {"left_out": "the time was up"}
        else:
            rows[name] = attempt(lambda name=name, vmap=vmap: prepared(name, vmap))
    field = {name: engine for name, (engine, _) in ready.items()}
    amounts = {name: amount for name, (_, amount) in ready.items()}
    for name, timings in timing.in_turn(field, amounts, REPEATS).items():
        rows[name]["steps_per_s"] = timing.rate(timings)
        rows[name]["steps_of_each"] = amounts[name]
    return {"walkers": size, "engines": rows}


if __name__ == "__main__":
    sys.exit(cli.run("gpu_check.py", GpuCheck))
