"""A study without physics: a genotype's fitness is minus its squared distance from a hidden point.

It obeys the interfaces of an experiment and of an evaluator, and a generation takes a millisecond.
"""

import dataclasses
import functools
import sys
import time
from typing import Any, Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk import evaluation, experiments, strategies
from mjxwalk.evolution import Goal
from mjxwalk.experiments.experiment import StrategyChoice
from mjxwalk.rollout import Outcome

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
        return _make_strategy(self.strategy.name, self.population_size, options)

    def sample_terrains(
        self, key: PRNGKeyArray, num: int, generation: int
    ) -> Float[Array, "terrain node"]:
        """Returns how far the hidden point moves."""
        return self.env.terrain.roughness * jax.random.normal(key, (num, 1))

    def rollout(self, genotype: Genotype, terrain: Float[Array, " node"]) -> Outcome:
        """Returns minus the squared distance from the point at 1 + terrain."""
        off = jnp.sum((genotype.gain - 1 - terrain) ** 2) + (genotype.bias - 1) ** 2
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
    name: str, population_size: int, options: tuple[tuple[str, Any], ...]
) -> strategies.Strategy[Any, Any]:
    # JAX compiles anew for functions that it has not met; so the tests compile once.
    return strategies.make(name, population_size=population_size, **dict(options))


class ToyEvaluator:
    """Evaluates the toy on the CPU, as long as it was told to take."""

    def __init__(self, study: Toy, engine: str) -> None:
        if engine not in ("auto", "mjx"):
            raise ValueError(f"engine must be one of auto, mjx, got {engine!r}")
        self.engine, self.why, self.devices = "mjx", "the toy has one", "1 x cpu"
        self.compile_s = 0.0
        self._delay_s = study.env.delay_s
        self._run = _run

    def evaluate(self, population: Any, heights: Float[Array, "terrain node"]) -> Outcome:
        """Returns outcomes as numpy arrays [pop, terrain]."""
        time.sleep(self._delay_s)
        return jax.tree.map(np.asarray, self._run(population, heights))


@jax.jit
@functools.partial(jax.vmap, in_axes=(0, None))
@functools.partial(jax.vmap, in_axes=(None, 0))
def _run(genotype: Genotype, terrain: Float[Array, " node"]) -> Outcome:
    return Toy().rollout(genotype, terrain)


def _names() -> dict[str, str]:
    return {"toy": "no physics, for tests"}


def _get(name: str) -> Toy:
    if name != "toy":
        raise ValueError(f"unknown experiment {name!r}")
    return Toy()


def install(patch: pytest.MonkeyPatch) -> None:
    """Makes the toy the only experiment that the command line knows."""
    patch.setattr(experiments, "names", _names)
    patch.setattr(experiments, "get", _get)
    patch.setattr(experiments, "DEFAULT", "toy")
    patch.setattr(evaluation, "make_evaluator", ToyEvaluator)


if __name__ == "__main__":
    from mjxwalk.cli import main

    install(pytest.MonkeyPatch())
    sys.exit(main())
