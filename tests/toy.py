"""A study without physics: a genotype's fitness is minus its squared distance from a hidden point.

It obeys the interfaces of an experiment and of an evaluator, and a generation takes a millisecond.
"""

import dataclasses
import functools
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk import evaluation, evolution, experiments, runs, strategies, tournament, walkers
from mjxwalk.envs import Trial, Trials
from mjxwalk.evolution import Reporter, RunRecorder, runner
from mjxwalk.experiments import registry
from mjxwalk.experiments.experiment import StrategyChoice
from mjxwalk.experiments.goal import Goal
from mjxwalk.experiments.growth import Growth
from mjxwalk.experiments.pruning import Pruning
from mjxwalk.experiments.run_config import Config
from mjxwalk.experiments.study import Study
from mjxwalk.experiments.study_config import StudyConfig
from mjxwalk.rollout import Outcome
from mjxwalk.runs import Metrics, Result, result

GENERATION_STEPS = 100  # physics steps that each trial claims


@dataclasses.dataclass(frozen=True, kw_only=True)
class Ground:
    """Where the hidden point lies, and how far it moves with the terrain."""

    roughness: float = 0.01
    shape: Literal["flat", "steps"] = "flat"

    def __post_init__(self) -> None:
        if self.roughness < 0:
            raise ValueError(f"roughness must not be negative, got {self.roughness}")


@dataclasses.dataclass(frozen=True, kw_only=True)
class World:
    """The toy's environment."""

    terrain: Ground = Ground()
    friction: float = 1.0
    delay_s: float = 0.0  # that an evaluation takes at least
    timestep: float = 0.001


class Genotype(NamedTuple):
    """Two leaves, so that a population is a tree."""

    gain: Float[Array, "2 3"]
    bias: Float[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Toy:
    """An experiment as the runs see it."""

    name: str = "toy"
    env: World = World()
    strategy: StrategyChoice = StrategyChoice(
        name="self-adaptive-ga", options={"sigma": 0.05, "initial_sigma": 0.3}
    )
    population_size: int = 16
    generations: int = 6
    terrains_per_evaluation: int = 2
    goal: Goal = Goal()
    start: Literal["zero", "winner", "mean", "population"] = "zero"
    pruning: Pruning | None = None
    growth: Growth | None = None

    def __post_init__(self) -> None:
        for name in ("population_size", "generations", "terrains_per_evaluation"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")

    @property
    def weight(self) -> float:
        """Body weight, N."""
        return 10.0

    def template(self) -> Genotype:
        """Returns zeros."""
        return Genotype(jnp.zeros((2, 3)), jnp.zeros(()))

    def make_strategy(self) -> strategies.Strategy[Any, Any]:
        """Returns the strategy."""
        options = tuple(self.strategy.options.items())
        return _make_strategy(self.strategy.name, self.population_size, options, self.pruning)

    def take_over(self, strategy: Any, state: Any, before: Any, elite_fitness: Any) -> Any:
        """Returns the strategy's state with another put in."""
        if self.pruning is None:
            return runs.unflatten(state, before)
        return jax.jit(strategy.begin)(runs.unflatten(state.inner, before), elite_fitness)

    def as_tested(self) -> "Toy":
        """Returns the toy."""
        return self

    def finer(self, factor: int) -> "Toy":
        """Returns the toy with another time step, which changes nothing."""
        env = dataclasses.replace(self.env, timestep=self.env.timestep / factor)
        return dataclasses.replace(self, env=env)

    def first_roughness(self) -> float:
        """Returns how far the hidden point moves in generation 1."""
        return self.env.terrain.roughness

    def next_roughness(self, roughness: float, distance: Any) -> float:
        """Returns how far it moves next."""
        return roughness

    def sample_trials(self, key: PRNGKeyArray, num: int, roughness: float | None = None) -> Trials:
        """Returns where the hidden point moves."""
        far = self.env.terrain.roughness if roughness is None else roughness
        return Trials(far * jax.random.normal(key, (num, 1)))

    def rollout(self, genotype: Genotype, given: Trial) -> Outcome:
        """Returns minus the squared distance from the point at 1 + the ground's height."""
        moved = given.ground.heights[given.ground.row]
        off = jnp.sum((genotype.gain - 1 - moved) ** 2) + (genotype.bias - 1) ** 2
        return Outcome(
            fitness=-off,
            distance=10 - off,
            duration=jnp.asarray(2.0),
            fell=off > 5,
            diverged=jnp.asarray(False),
            torque_cost=off,
            work=jnp.asarray(40.0),
            steps=jnp.asarray(GENERATION_STEPS),
        )

    def weight_table(self, genotype: Genotype) -> list[tuple[str, str, float]]:
        """Returns the gains as rows."""
        gain = np.asarray(genotype.gain)
        return [(f"network {i}", f"input {j}", float(gain[i, j])) for i, j in np.ndindex(2, 3)]


@functools.cache
def _make_strategy(
    name: str, population_size: int, options: tuple[tuple[str, Any], ...], pruning: Pruning | None
) -> strategies.Strategy[Any, Any]:
    # JAX compiles anew for functions that it has not met; so the tests compile once.
    strategy = strategies.make(name, population_size=population_size, **dict(options))
    if pruning is None:
        return strategy
    links = Genotype(np.arange(6).reshape(2, 3), np.asarray(-1))  # type: ignore[arg-type]
    return strategies.with_pruning(strategy, links=links, **dataclasses.asdict(pruning))


class ToyEvaluator:
    """Evaluates the toy on the CPU, as long as it was told to take."""

    def __init__(self, study: Toy, engine: str) -> None:
        if engine not in ("auto", "mjx"):
            raise ValueError(f"engine must be one of auto, mjx, got {engine!r}")
        self.engine, self.why, self.devices = "mjx", "the toy has one", "1 x cpu"
        self.compile_s = 0.0
        self._delay_s = study.env.delay_s
        self._run = _run

    def prepare(self, population: Any, trials: Any) -> None:
        """Needs nothing."""

    def evaluate(self, population: Any, trials: Trials) -> Outcome:
        """Returns outcomes as numpy arrays [pop, trial]."""
        time.sleep(self._delay_s)
        rows = np.arange(trials.num, dtype=np.int32)
        return jax.tree.map(np.asarray, self._run(population, trials, rows))


@jax.jit
@functools.partial(jax.vmap, in_axes=(0, None, None))
@functools.partial(jax.vmap, in_axes=(None, None, 0))
def _run(genotype: Genotype, trials: Trials, row: Int[Array, ""]) -> Outcome:
    return Toy().rollout(genotype, trials.given(row))


class Silent:
    """Takes down what is said, and shows nothing."""

    def __init__(self) -> None:
        self.said: list[str] = []

    def generation(self, line: Metrics, /) -> None:
        """Does nothing."""

    def say(self, text: str, /) -> None:
        """Takes it down."""
        self.said.append(text)


def evolve(path: Path, settings: Config, reporter: Reporter | None = None, **others: Any) -> Result:
    """Evolves a toy in its folder, or goes on with it.

    Args:
      path: of the folder, which holds the settings.
      settings: of the run.
      reporter: is told of each generation; None for nobody.
      others: arguments of `mjxwalk.evolution.evolve`.
    """
    evaluator = ToyEvaluator(settings.experiment, "auto")
    with RunRecorder(path, settings, reporter or Silent()) as recorder:
        evolution.evolve(settings, evaluator, recorder, **others)
    finished = result.read(path)
    assert finished is not None
    return finished


_ZERO = Toy(name="toys/zero")
TOY = Toy()
_NEAR = Toy(name="toys/near", start="winner", generations=4)
STUDY = Study(
    name="toys",
    phases=(
        ("zero", _ZERO),
        ("near", _NEAR),
        (
            "pruned",
            dataclasses.replace(
                _NEAR,
                name="toys/pruned",
                start="population",
                generations=30,
                # The toy's fitness is negative, so that pruning ends as soon as it began.
                pruning=Pruning(every=2, reference=3, window=2, settle=3),
            ),
        ),
    ),
)


def hold_tournament(place: Path, study: StudyConfig, say: Callable[[str], None]) -> None:
    """Makes the third youngest elite the winner without a trial."""
    entrants = walkers.entrants(place)
    winner = int(entrants.generations[-3:][0])
    say(f"the winner is of generation {winner}")
    held = tournament.Tournament(
        entrants=len(entrants),
        newest_generation=int(entrants.generations[-1]),
        winner_generation=winner,
        screening_terrains=1,
        seed=study.seed,
        engine="mjx",
        roughness_m=None,
        conditions=(),
    )
    tournament.write(place, held, entrants.of_generation(winner))


def install(patch: pytest.MonkeyPatch) -> None:
    """Makes the toy and its study the only ones that the command line knows."""
    phases = {name: "a phase of the toys" for name, _ in STUDY.phases}
    toys = registry.Entry("toy", "STUDY", "three phases without physics", phases)
    patch.setattr(
        registry, "EXPERIMENTS", {"toy": registry.Entry("toy", "TOY", "no physics, for tests")}
    )
    patch.setattr(registry, "STUDIES", {"toys": toys})
    patch.setattr(experiments, "DEFAULT", "toy")
    patch.setattr(evaluation, "make_evaluator", ToyEvaluator)
    patch.setattr(runner, "hold_tournament", hold_tournament)


if __name__ == "__main__":
    from mjxwalk.cli import main

    # A shell's background jobs, and so their children, ignore Ctrl-C.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    install(pytest.MonkeyPatch())
    sys.exit(main())
