"""Measures how the time of a physics step grows with the network that decides.

    python scripts/network_cost.py --body walker2d

Each network is compiled in a process of its own, with nothing kept from before. Then all of them
take turns in one process, which counts the CPU time of its threads: whatever else the machine does
at the time hits all of them alike. As their networks say nothing at first, all walkers walk alike,
and take the same steps; every walker has weights of its own in memory, as in an evolution.
"""

import dataclasses
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from mjxwalk import cli
from mjxwalk.errors import RunError

TIMED = 0.2  # CPU seconds of a timing; ours
ENDLESS = {  # so that a trial lasts as long as it is told to
    "min_height": 1e-3,
    "max_pitch": 1e6,
    "max_flight_time": 1e6,
    "max_lag": 1e6,
    "torque_budget": 1e9,
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class NetworkCost:
    """Measure how the time of a physics step grows with the network.

    Attributes:
      body: name of a body that ships, or its file.
      hidden: units of the perceptrons' layers, such as 8 or 64x64; beside them stands linear
        feedback.
      population: walkers at once.
      seconds: that a trial lasts.
      repeats: timings that a median is of.
      compile_only: measure what compiling one network takes, "" for linear feedback, and print it
        as JSON.
    """

    body: Path = Path("walker2d")
    hidden: tuple[str, ...] = ("8", "64x64", "256x256")
    population: int = 256
    seconds: float = 2.0
    repeats: int = 15
    compile_only: str | None = None

    def run(self) -> int:
        """Prints the table and returns the exit code.

        Raises:
          RunError: an argument is wrong, or a network cannot be compiled.
        """
        for name in ("population", "repeats"):
            if getattr(self, name) < 1:
                raise RunError(f"--{name} must be at least 1, got {getattr(self, name)}")
        from mjxwalk import engines

        engines.prepare()
        if self.compile_only is not None:
            print(json.dumps(self._compile(self.compile_only)))
            return 0
        networks = ("", *self.hidden)
        for network in networks:
            self._experiment(network)  # refuses what is wrong before any work
        with tempfile.TemporaryDirectory() as cache:
            os.environ["XDG_CACHE_HOME"] = cache
            os.environ.pop("JAX_COMPILATION_CACHE_DIR", None)
            compiled = {network: self._in_own_process(network) for network in networks}
            seconds = self._take_turns(networks)
        print("| network | weights | compiling (CPU s) | memory (GB) | step (us CPU) | times |")
        print("| --- | ---: | ---: | ---: | ---: | ---: |")
        for network in networks:
            took, (step, times) = compiled[network], seconds[network]
            print(
                f"| {network or 'linear'} | {took['weights']:,} | {took['seconds']:.0f} | "
                f"{took['bytes'] / 1e9:.1f} | {1e6 * step:.2f} | {times:.2f} |"
            )
        return 0

    def _experiment(self, network: str) -> Any:
        """Returns the experiment in which a network decides."""
        from mjxwalk import experiments
        from mjxwalk.cli import own_body
        from mjxwalk.settings import override

        experiment = experiments.get("walk+mlp" if network else "walk")
        experiment = own_body.put(experiment, self.body)
        for name, value in {**ENDLESS, "max_time": self.seconds}.items():
            experiment = override(experiment, f"env.{name}", str(value))
        if network:
            layers = ",".join(network.split("x"))
            experiment = override(experiment, "controller.hidden", f"[{layers}]")
        return experiment

    def _given(self, network: str) -> tuple[Any, Any, Any]:
        """Returns a network's evaluator, its population, and the trial that all are given."""
        import jax
        import numpy as np

        from mjxwalk import evaluation

        experiment = self._experiment(network)
        population = jax.tree.map(
            lambda leaf: np.repeat(np.asarray(leaf)[None], self.population, axis=0),
            experiment.template(),
        )
        trials = experiment.sample_trials(jax.random.key(0), 1)
        return evaluation.make_evaluator(experiment, "lanes"), population, trials

    def _compile(self, network: str) -> dict[str, float]:
        import jax

        from mjxwalk.bench.child import peak_bytes

        evaluator, population, trials = self._given(network)
        started = time.process_time()
        evaluator.prepare(population, trials)
        seconds = time.process_time() - started
        weights = sum(leaf[0].size for leaf in jax.tree.leaves(population))
        return {"weights": weights, "seconds": seconds, "bytes": peak_bytes()}

    def _in_own_process(self, network: str) -> dict[str, float]:
        """Returns what compiling took in a process of its own; what it compiled is kept."""
        args = [f"--{name}={getattr(self, name)}" for name in ("body", "population", "seconds")]
        command = [sys.executable, __file__, *args, f"--compile-only={network}"]
        done = subprocess.run(command, capture_output=True, encoding="utf-8", errors="replace")
        if done.returncode:
            last = (done.stderr.strip().splitlines() or ["it was killed"])[-1]
            raise RunError(f"{network or 'linear'} cannot be compiled: {last}")
        return json.loads(done.stdout.splitlines()[-1])

    def _take_turns(self, networks: tuple[str, ...]) -> dict[str, tuple[float, float]]:
        """Returns the CPU seconds of a physics step of one walker, and as times of linear feedback.

        Of both it is the median; the second of ratios of timings that followed on each other.
        """
        import numpy as np

        from mjxwalk.bench import timing

        def contender(network: str) -> timing.Contender:
            evaluator, population, trials = self._given(network)

            def walk(amount: int) -> int:
                return sum(
                    int(evaluator.evaluate(population, trials).steps.sum()) for _ in range(amount)
                )

            return walk

        clock = time.process_time
        field = {network: contender(network) for network in networks}
        amounts = {name: timing.calibrate(walk, TIMED, clock) for name, walk in field.items()}
        taken = timing.in_turn(field, amounts, self.repeats, clock)
        steps = {name: np.array([t.seconds / t.work for t in each]) for name, each in taken.items()}
        return {
            name: (float(np.median(each)), float(np.median(each / steps[""])))
            for name, each in steps.items()
        }


if __name__ == "__main__":
    sys.exit(cli.run("network_cost.py", NetworkCost))
