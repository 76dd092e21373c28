"""One generation: ask, evaluate, tell.

A run is a function of its settings and its seed. Generation g, counted from 1, draws all that it
draws from fold_in(key(seed), g); fold_in(key(seed), 0) serves what comes before and after them.
"""

import functools
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int, PRNGKeyArray

from mjxwalk import forking
from mjxwalk.engines.pinning import pinned
from mjxwalk.errors import RunError, first_line
from mjxwalk.evolution import growing, memory, sensed
from mjxwalk.evolution.elites import Elites, fittest
from mjxwalk.evolution.evolvable import Evaluator, Evolvable
from mjxwalk.evolution.generation_metrics import MeanOutcome, measure, summarise
from mjxwalk.evolution.sensed import Sensed
from mjxwalk.experiments.goal import take
from mjxwalk.outcomes import over_terrains
from mjxwalk.rollout import TrialRunner
from mjxwalk.runs import Metrics
from mjxwalk.runs.inheritance import Inherited
from mjxwalk.runs.trees import unflatten

# Folded into the seed's key of runs that start from others, so that the phases of a study, which
# share a seed, share no random numbers; no generation has so high a number.
STREAMS = {"winner": 2**32 - 1, "population": 2**32 - 2, "mean": 2**32 - 3}


class RunState(NamedTuple):
    """All that a run needs to go on, and what its last generation did.

    Attributes:
      generation: evaluated last, 0 before the first.
      key: data of the run's random key.
      strategy: the strategy's state after `tell`.
      population: genotypes asked for last, leaves [pop, ...].
      fitness: of each, mean over its terrains; NaN if a trial's is, or if it was not evaluated.
      outcome: what else they did; NaN of those that were not evaluated.
      elite: the fittest of them, or the one that reached the goal.
      elites: that of each of the last generations.
      reached: whether the elite has reached the experiment's goal.
      roughness: of the next generation's ground, m.
      sensed: what all populations so far have sensed, which the next one's genotypes carry; None of
        a controller that does not normalise its senses.
    """

    generation: Int[np.ndarray, ""]
    key: Any
    strategy: Any
    population: Any
    fitness: Float[np.ndarray, " pop"]
    outcome: MeanOutcome
    elite: Any
    elites: Elites
    reached: Bool[np.ndarray, ""]
    roughness: Float[np.ndarray, ""]
    sensed: Sensed | None = None


class Evolution:
    """An experiment, its strategy and an evaluator, compiled once for all generations."""

    def __init__(
        self, experiment: Evolvable, evaluator: Evaluator, finer: TrialRunner | None = None
    ) -> None:
        """Args: experiment: to evolve. evaluator: of it. finer: of its goal's fine trials."""
        self._experiment = experiment
        self._evaluator = evaluator
        self._finer = finer
        self._compile_s = evaluator.compile_s
        self._growth = growing.of(experiment)
        strategy = experiment.make_strategy()
        self._take_over = functools.partial(experiment.take_over, strategy)
        self._init = jax.jit(strategy.init)
        self._ask = jax.jit(strategy.ask)
        self._tells = {strategy.population_size: jax.jit(strategy.tell)}

    @pinned()
    def start(self, seed: int, inherited: Inherited | None = None) -> RunState:
        """Returns the state before generation 1, with everything compiled.

        Args:
          seed: of all random numbers.
          inherited: what the run starts from; None for zero.

        Raises:
          RunError: that does not fit the experiment, or the population not into memory, or JAX
            cannot compute in this process.
        """
        forking.check()
        key = jax.random.key(seed)
        template = self._experiment.template()
        if inherited is not None:
            key = jax.random.fold_in(key, STREAMS[self._experiment.start])
        if inherited is not None and inherited.genotype:
            template = unflatten(template, inherited.genotype)
        key_init, _ = outer_keys(key)
        memory.check(jax.eval_shape(self._population, key_init, template))
        # XLA compiles the strategy while the engine compiles the trials: neither needs all cores.
        with ThreadPoolExecutor(1) as other:
            preparing = other.submit(self._prepare, template)
            strategy = _on_host(self._init(key_init, template))
            self._rehearse(strategy)
            try:
                preparing.result()
            except (TypeError, ValueError) as error:  # of a body and a controller that do not fit
                raise RunError(
                    f"the trials of this experiment cannot be computed: {first_line(error)}"
                ) from error
        if inherited is not None and inherited.strategy:
            taken = self._take_over(strategy, inherited.strategy, inherited.elite_fitness)
            strategy = _on_host(taken)
        population, _ = jax.eval_shape(self._ask, key, strategy)
        empty = np.full(growing.size_of(population), np.nan, np.float32)
        return RunState(
            generation=np.zeros((), np.int32),
            key=np.asarray(jax.random.key_data(key)),
            strategy=strategy,
            population=jax.tree.map(lambda leaf: np.zeros(leaf.shape, leaf.dtype), population),
            fitness=empty,
            outcome=MeanOutcome(*[empty] * len(MeanOutcome._fields)),
            elite=_on_host(template),
            elites=Elites.none(template),
            reached=np.zeros((), bool),
            roughness=np.asarray(self._experiment.first_roughness(), np.float64),
            sensed=_inherited_senses(sensed.begin(template), inherited),
        )

    def _population(self, key: PRNGKeyArray, template: Any) -> tuple[Any, Any]:
        """Returns the first population, and the strategy's state."""
        return self._ask(key, self._init(key, template))

    @pinned()  # in a thread of its own
    def _prepare(self, template: Any) -> None:
        """Compiles the trials of a generation."""
        experiment = self._experiment

        def shapes(key: PRNGKeyArray, template: Any) -> Any:
            population, _ = self._population(key, template)
            population = growing.like_a_part(self._growth, population)
            return population, experiment.sample_trials(key, experiment.terrains_per_evaluation)

        self._evaluator.prepare(*jax.eval_shape(shapes, jax.random.key(0), template))

    def _rehearse(self, strategy: Any) -> None:
        """Compiles what a generation does with the strategy's state, by doing it for nothing."""
        key = jax.random.key(0)
        self._experiment.sample_trials(key, self._experiment.terrains_per_evaluation)
        population, asked = self._ask(key, strategy)
        zeros = np.zeros(growing.size_of(population), np.float32)
        self._tell(key, _on_host(population), zeros, asked)

    def _tell(self, key: PRNGKeyArray, population: Any, fitness: Any, asked: Any) -> Any:
        """Returns the strategy's state and metrics, told of as many genotypes as were evaluated."""
        size = fitness.size
        if size not in self._tells:
            self._tells[size] = jax.jit(growing.strategy_of(self._experiment, size).tell)
        return self._tells[size](key, population, fitness, asked)

    @pinned()
    def advance(self, state: RunState, since: float | None = None) -> tuple[RunState, Metrics]:
        """Returns the state after one more generation, and its figures.

        Args:
          state: before it.
          since: when its time began on the clock `time.perf_counter`; None for now.
        """
        started = time.perf_counter() if since is None else since
        compiled = self._evaluator.compile_s
        generation = int(state.generation) + 1
        key = jax.random.fold_in(jax.random.wrap_key_data(jnp.asarray(state.key)), generation)
        key_ask, key_trials, key_tell, *keys_goal = jax.random.split(key, 5)
        experiment = self._experiment
        trials = experiment.sample_trials(
            key_trials, experiment.terrains_per_evaluation, float(state.roughness)
        )
        population, asked = self._ask(key_ask, state.strategy)
        asked_for = _on_host(population)
        population = sensed.put(asked_for, state.sensed)
        asking_done = time.perf_counter()
        evaluated = growing.evaluate(self._growth, self._evaluator, population, trials)
        genotypes, outcome = evaluated.genotypes, evaluated.outcome
        evaluating_done = time.perf_counter()
        fitness = over_terrains(outcome.fitness)
        strategy, told = self._tell(key_tell, take(asked_for, evaluated.places), fitness, asked)
        passed = experiment.goal.find(
            experiment,
            self._evaluator,
            genotypes,
            outcome,
            (keys_goal[0], keys_goal[1]),
            self._finer,
        )
        best = fittest(fitness) if passed is None else passed
        elite = take(genotypes, best)

        def spread(values: Any) -> Any:
            return growing.spread(values, evaluated, growing.size_of(population))

        after = RunState(
            generation=np.asarray(generation, np.int32),
            key=state.key,
            strategy=_on_host(strategy),
            population=population,
            fitness=spread(fitness),
            outcome=jax.tree.map(spread, summarise(outcome)),
            elite=elite,
            elites=state.elites.push(elite, fitness[best], generation),
            reached=np.asarray(passed is not None),
            roughness=np.asarray(
                experiment.next_roughness(float(state.roughness), over_terrains(outcome.distance)),
                np.float64,
            ),
            sensed=None if state.sensed is None else state.sensed.add(outcome.sensed),
        )
        evaluate_s = evaluating_done - asking_done - (self._evaluator.compile_s - compiled)
        compile_s = max(0.0, self._evaluator.compile_s - self._compile_s)
        self._compile_s = self._evaluator.compile_s
        return after, measure(
            outcome,
            best,
            generation=generation,
            weight=experiment.weight,
            told=told,
            evaluate_s=evaluate_s,
            compile_s=compile_s,
            other_s=max(0.0, time.perf_counter() - started - evaluate_s - compile_s),
            num_evaluated=None if self._growth is None else fitness.size,
        )


def _inherited_senses(begun: Sensed | None, inherited: Inherited | None) -> Sensed | None:
    """Returns what an inherited population has sensed, else what a run begins with."""
    if inherited is None or not inherited.sensed:
        return begun
    return unflatten(begun, inherited.sensed)


def is_over(state: RunState, experiment: Evolvable) -> bool:
    """Returns whether a run has no generation left."""
    if bool(state.reached) or int(state.generation) >= experiment.generations:
        return True
    # A strategy that prunes ends by itself.
    return bool(getattr(state.strategy, "finished", False))


def outer_keys(key: PRNGKeyArray) -> tuple[PRNGKeyArray, PRNGKeyArray]:
    """Returns the run's keys that belong to no generation: of the start, and of the champion."""
    key_start, key_champion = jax.random.split(jax.random.fold_in(key, 0))
    return key_start, key_champion


def _on_host(tree: Any) -> Any:
    # A state as it comes back from the disk; it also keeps JAX from compiling a second time for
    # arrays that differ only in whether their type is weak.
    return jax.tree.map(np.asarray, tree)
