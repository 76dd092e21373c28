"""What `mjxwalk bench strategies` compares: our strategies and others' on functions to minimise."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk import strategies
from mjxwalk.bench import functions
from mjxwalk.bench.functions import Function
from mjxwalk.strategies import Strategy

SIGMA = 1.0  # of generation 0; starts are uniform in a cube of sides 6
NARROW_SIGMA = 0.1  # of the noise of those that do not adapt it
LEARNING_RATE = 0.03

FUNCTIONS: Mapping[str, Function] = {
    "sphere": functions.sphere,
    "rosenbrock": functions.rosenbrock,
    "rastrigin": functions.rastrigin,
    "ellipsoid": functions.ellipsoid,
}


class Pair(NamedTuple):
    """One algorithm, ours and evosax's, with the same settings.

    Attributes:
      ours: made for a population size.
      theirs: made for a population size and a number of weights, as one of ours.
      num_weights: at which speed is compared.
    """

    ours: Callable[[int], Strategy[Any, Any]]
    theirs: Callable[[int, int], Strategy[Any, Any]]
    num_weights: int = 1_000


def pairs() -> dict[str, Pair]:
    """Returns all algorithms that both have.

    Raises:
      ImportError: evosax is not installed.
    """
    from evosax import algorithms as evosax  # pyright: ignore[reportMissingTypeStubs]

    theirs: Any = evosax

    def adapted(name: str, **given: Any) -> Callable[[int, int], Strategy[Any, Any]]:
        def make(population_size: int, num_weights: int) -> Strategy[Any, Any]:
            algorithm = getattr(theirs, name)(population_size, jnp.zeros(num_weights), **given)
            params = algorithm.default_params
            if hasattr(params, "std_init"):
                params = params.replace(std_init=jnp.full_like(params.std_init, SIGMA))
            return strategies.from_evosax(algorithm, params)

        return make

    adam, sgd = optax.adam(LEARNING_RATE), optax.sgd(LEARNING_RATE)
    narrow = optax.constant_schedule(NARROW_SIGMA)
    return {
        "cma-es": Pair(
            lambda size: strategies.cma_es(population_size=size, sigma=SIGMA), adapted("CMA_ES")
        ),
        "sep-cma-es": Pair(
            lambda size: strategies.sep_cma_es(population_size=size, sigma=SIGMA),
            adapted("Sep_CMA_ES"),
        ),
        "snes": Pair(
            lambda size: strategies.snes(population_size=size, sigma=SIGMA), adapted("SNES")
        ),
        # evosax's holds a matrix for each genotype, of a thousand weights 16 GB. It takes the
        # exponential of each element, so that its axes stay those of the weights.
        "xnes": Pair(
            lambda size: strategies.xnes(population_size=size, sigma=SIGMA), adapted("xNES"), 100
        ),
        "openai-es": Pair(
            lambda size: strategies.openai_es(
                population_size=size, sigma=NARROW_SIGMA, optimizer=LEARNING_RATE
            ),
            adapted("Open_ES", optimizer=adam, std_schedule=narrow),
        ),
        "pgpe": Pair(
            lambda size: strategies.pgpe(
                population_size=size, sigma=SIGMA, optimizer=LEARNING_RATE
            ),
            adapted("PGPE", optimizer=adam),
        ),
        "ars": Pair(
            lambda size: strategies.ars(
                population_size=size, sigma=NARROW_SIGMA, learning_rate=LEARNING_RATE
            ),
            adapted("ARS", optimizer=sgd, std_schedule=narrow),
        ),
    }


def usual_population(num_weights: int) -> int:
    """Returns twice the tutorial's default of CMA-ES, 4 + 3 ln n, and so an even number."""
    return 2 * (4 + int(3 * math.log(num_weights)))


def start_points(seeds: int, num_weights: int) -> Float[Array, "seed dim"]:
    """Returns where searches begin."""
    key = jax.random.key(seeds)
    return jax.random.uniform(key, (seeds, num_weights), minval=-3.0, maxval=3.0)


def lowest(
    strategy: Strategy[Any, Any],
    starts: Float[Array, "seed dim"],
    generations: int,
    landscapes: Mapping[str, Function] = FUNCTIONS,
) -> dict[str, Float[np.ndarray, " seed"]]:
    """Returns the lowest value of each function that each search finds."""

    def run(key: PRNGKeyArray, start: Float[Array, " dim"], which: Any) -> Float[Array, ""]:
        def generation(carry: Any, key: PRNGKeyArray) -> tuple[Any, None]:
            state, best = carry
            key_ask, key_tell = jax.random.split(key)
            population, state = strategy.ask(key_ask, state)
            cost = jnp.stack([function(population) for function in landscapes.values()])[which]
            state, _ = strategy.tell(key_tell, population, -cost, state)
            known = jnp.where(jnp.isnan(cost), jnp.inf, cost)
            return (state, jnp.minimum(best, jnp.min(known))), None

        key_init, key_run = jax.random.split(key)
        begin = (strategy.init(key_init, start), jnp.asarray(jnp.inf))
        keys = jax.random.split(key_run, generations)
        return jax.lax.scan(generation, begin, keys)[0][1]

    # All functions in one program, which takes longer to compile than to run.
    over_seeds = jax.vmap(run, in_axes=(0, 0, None))
    over_all = jax.jit(jax.vmap(over_seeds, in_axes=(None, None, 0)))
    keys = jax.random.split(jax.random.key(0), starts.shape[0])
    found = np.asarray(over_all(keys, starts, jnp.arange(len(landscapes))), np.float64)
    return dict(zip(landscapes, found, strict=True))


def lowest_of_pycma(
    starts: Float[Array, "seed dim"], generations: int
) -> dict[str, Float[np.ndarray, " seed"]]:
    """Returns the same of CMA-ES by its author, in double precision.

    Raises:
      ImportError: pycma is not installed.
    """
    import cma  # pyright: ignore[reportMissingImports, reportMissingTypeStubs]

    package: Any = cma
    found: dict[str, Float[np.ndarray, " seed"]] = {}
    for name, function in FUNCTIONS.items():
        evaluate = jax.jit(function)
        values: list[float] = []
        for seed, start in enumerate(np.asarray(starts, np.float64)):
            options = {
                "popsize": usual_population(start.size),
                "seed": seed + 1,
                "verbose": -9,
                "maxiter": generations,
            }
            search = package.CMAEvolutionStrategy(start, SIGMA, options)
            while not search.stop():
                asked = search.ask()
                search.tell(asked, np.asarray(evaluate(jnp.asarray(np.array(asked)))).tolist())
            values.append(float(search.best.f))
        found[name] = np.array(values)
    return found
