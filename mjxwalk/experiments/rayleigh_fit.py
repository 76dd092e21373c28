"""Rayleigh oscillators fitted to how humans walk.

A thesis of the Indian Institute of Information Technology, Allahabad: "Designing CPG for Biped
Locomotion Control using Nonlinear Dynamical Theory", chapters 4 and 5.
"""

import dataclasses
import inspect
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk import gaits, strategies
from mjxwalk.analysis import fits
from mjxwalk.controllers.patterns import (
    HarmonicLegs,
    PatternGenerator,
    stride_time,
)
from mjxwalk.controllers.rayleigh import Motion
from mjxwalk.envs import Trial, Trials, checks
from mjxwalk.experiments.experiment import StrategyChoice
from mjxwalk.experiments.goal import Goal
from mjxwalk.gaits import NUM_POINTS, Gait
from mjxwalk.rollout import Outcome

ADULTS = "adults"
# ours: what a series of so many harmonics leaves out is the rounding of the data.
TARGET_HARMONICS = 10
POPULATION_SIZE = 100  # section 4.3.3, step 1
GENERATIONS = 1000  # section 4.3.3, step 6, of the genetic algorithm


@dataclasses.dataclass(frozen=True, kw_only=True)
class RayleighFit:
    """Oscillators, the gait that they are to draw, and how they evolve.

    The error of a joint is its human angle minus the oscillators', and fitness is minus the mean,
    over time and joints, of `proportional` |e| + `derivative` |de/dt| + `integral` |integral of e|.
    The thesis writes the terms without the bars, so that errors could cancel.

    Attributes:
      name: as the command line knows it.
      network: what the genotype becomes.
      gait: "adults", or the path of a CSV, .mot or .sto file.
      proportional: c1, without unit.
      derivative: c2, s.
      integral: c3, 1/s.
      settling_cycles: that pass before the error is measured.
      cycles: that it is measured over.
      strategy: what turns a population and its fitness into the next population.
      population_size: genotypes a generation.
      generations: how many of them.
    """

    name: str
    network: Any
    strategy: StrategyChoice
    gait: str = ADULTS
    proportional: float = 1.0  # ours: the thesis gives none of the three
    derivative: float = 0.01
    integral: float = 0.1
    settling_cycles: int = 0
    cycles: int = 40  # ours: over the 5 s of its figures, all but one joint may be left to chance
    population_size: int = POPULATION_SIZE
    generations: int = GENERATIONS

    def __post_init__(self) -> None:
        checks.count(self, "population_size", "generations", "cycles")
        checks.not_negative(self, "proportional", "derivative", "integral", "settling_cycles")
        steps = NUM_POINTS * (self.settling_cycles + self.cycles)
        if steps > checks.MOST_STEPS:
            raise ValueError(
                f"settling_cycles and cycles must be {checks.MOST_STEPS // NUM_POINTS:,} together "
                f"at most, got {self.settling_cycles} and {self.cycles}"
            )

    @property
    def terrains_per_evaluation(self) -> int:
        """One: nothing is drawn."""
        return 1

    @property
    def goal(self) -> Goal:
        """None."""
        return Goal()

    @property
    def pruning(self) -> None:
        """None."""

    @property
    def start(self) -> str:
        """From zero."""
        return "zero"

    @property
    def weight(self) -> float:
        """Nothing is moved, so any serves, N."""
        return 1.0

    @property
    def unit(self) -> str:
        """Of the error."""
        return "degrees"

    @property
    def save_every(self) -> int:
        """A second or so; a checkpoint takes longer than a generation."""
        return 100

    def describe(self) -> str:
        """Returns what is fitted to what."""
        return f"{_words(self.network)} to the gait of {self.target().name}"

    def generator(self) -> PatternGenerator:
        """Returns the network."""
        return self.network

    def target(self) -> Gait:
        """Returns the gait.

        Raises:
          RunError: the file cannot be read, or is malformed.
        """
        return gaits.adults() if self.gait == ADULTS else gaits.read(Path(self.gait))

    def template(self) -> Any:
        """Returns a genotype."""
        return self.generator().template()

    def make_strategy(self) -> strategies.Strategy[Any, Any]:
        """Returns the strategy, told the network's bounds if it asks for any.

        Raises:
          ValueError: the strategy or one of its options does not exist, or has a wrong value.
        """
        lower, upper = self.generator().bounds()
        factory = strategies.FACTORIES.get(self.strategy.name)
        options = inspect.signature(factory).parameters if factory is not None else {}
        known: dict[str, Any] = {"lower": lower, "upper": upper}
        if "scale" in options:
            # So that a mesh of 1 spans the range of each weight.
            known["scale"] = jax.tree.map(lambda low, high: high - low, lower, upper)
        given = {name: value for name, value in known.items() if name in options}
        return strategies.make(
            self.strategy.name,
            population_size=self.population_size,
            **{**given, **self.strategy.options},
        )

    def take_over(
        self, strategy: Any, state: Any, before: Mapping[str, Any], elite_fitness: Any
    ) -> Any:
        """Returns the state: a fit starts from zero."""
        del strategy, before, elite_fitness
        return state

    def first_roughness(self) -> float:
        """Returns 0: there is no ground."""
        return 0.0

    def next_roughness(self, roughness: float, distance: Float[np.ndarray, " pop"]) -> float:
        """Returns 0: there is no ground."""
        del roughness, distance
        return 0.0

    def sample_trials(self, key: PRNGKeyArray, num: int, roughness: float | None = None) -> Trials:
        """Returns flat ground that nobody stands on."""
        del key, roughness
        return Trials(jnp.zeros((num, 1)))

    def simulate(self, genotype: Any, cycles: int, start: Any = None) -> Motion:
        """Returns the joints' motion at every percent of some cycles from the start on: [time, 4].

        Args:
          genotype: of the network.
          cycles: of the human, 100 steps each.
          start: the network's state at first; None for that at the left heel's strike.
        """
        generator, gait = self.generator(), self.target()
        timestep = stride_time(gait) / NUM_POINTS
        network, usual = generator.begin(genotype, gait)

        def one(state: Any, _: None) -> tuple[Any, Motion]:
            return generator.step(network, state, timestep), generator.read(network, state)

        first = usual if start is None else start
        return jax.lax.scan(one, first, length=cycles * NUM_POINTS)[1]

    def settle(self, genotype: Any, cycles: int) -> Any:
        """Returns the network's state some cycles after the start."""
        _, start = self.generator().begin(genotype, self.target())
        return self.settle_steps(genotype, start, cycles * NUM_POINTS)

    def settle_steps(self, genotype: Any, start: Any, num_steps: int) -> Any:
        """Returns the network's state some percents of a cycle after another."""
        generator, gait = self.generator(), self.target()
        timestep = stride_time(gait) / NUM_POINTS
        network, _ = generator.begin(genotype, gait)
        return jax.lax.fori_loop(
            0, num_steps, lambda _, state: generator.step(network, state, timestep), start
        )

    def judge(self, genotype: Any) -> dict[str, float]:
        """Returns the root mean square of each joint's error, degrees, and the worst in the end."""
        fit = fits.measure(self, genotype)
        return fit.by_joint() | {"worst once settled": float(fit.settled_rms.max())}

    def rollout(self, genotype: Any, given: Trial) -> Outcome:
        """Returns the fitness of one genotype; there is no ground."""
        del given
        generator, gait = self.generator(), self.target()
        network, state = generator.begin(genotype, gait)
        timestep = stride_time(gait) / NUM_POINTS
        table = jnp.asarray(_targets(gait))
        settling, total = (NUM_POINTS * n for n in (self.settling_cycles, self.cycles))

        class Loop(NamedTuple):
            """What is carried from step to step."""

            step: Int[Array, ""]
            state: Any
            summed: Float[Array, "4"]
            error: Float[Array, ""]

        def going_on(loop: Loop) -> Any:
            return loop.step < settling + total

        def one(loop: Loop) -> Loop:
            motion = generator.read(network, loop.state)
            wanted = table[loop.step % NUM_POINTS]
            counts = jnp.where(loop.step >= settling, 1.0, 0.0)
            off = counts * (wanted[:4] - motion.angle)
            off_rate = counts * (wanted[4:] - motion.rate)
            summed = loop.summed + timestep * off
            error = (
                self.proportional * jnp.abs(off)
                + self.derivative * jnp.abs(off_rate)
                + self.integral * jnp.abs(summed)
            )
            return Loop(
                step=loop.step + 1,
                state=generator.step(network, loop.state, timestep),
                summed=summed,
                error=loop.error + jnp.sum(error),
            )

        start = Loop(jnp.zeros((), jnp.int32), state, jnp.zeros(4), jnp.zeros(()))
        end = jax.lax.while_loop(going_on, one, start)
        fitness = -end.error / (4.0 * total)
        none = jnp.zeros(())
        return Outcome(
            fitness=fitness,
            distance=jnp.full((), jnp.nan),
            duration=none,
            fell=jnp.zeros((), bool),
            diverged=~jnp.isfinite(fitness),
            torque_cost=none,
            work=none,
            steps=end.step,
        )

    def weight_table(self, genotype: Any) -> list[tuple[str, float]]:
        """Returns a genotype as rows of name and value."""
        return self.generator().table(genotype)


def _targets(gait: Gait) -> Float[np.ndarray, "100 8"]:
    """Returns four angles at every percent of the cycle, degrees, and their rates, degrees/s."""
    phase = 2 * np.pi * np.arange(NUM_POINTS) / NUM_POINTS
    faster = 2 * np.pi / stride_time(gait)
    curves: list[Any] = []
    for derivative in (0, 1):
        for curve in (gait.hip, gait.knee):
            series = gaits.harmonics(curve, TARGET_HARMONICS)
            left = faster**derivative * gaits.evaluate(series, phase, derivative)
            curves += [left, np.roll(left, NUM_POINTS // 2)]
    return np.stack(curves, axis=1).astype(np.float32)


def _words(network: PatternGenerator) -> str:
    if isinstance(network, HarmonicLegs):
        return f"{network.num_harmonics} Rayleigh oscillators a leg"
    return "four Rayleigh oscillators"
