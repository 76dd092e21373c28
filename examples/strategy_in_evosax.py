"""Runs one of mjxwalk's strategies as an algorithm of evosax, which minimises.

pip install evosax
python examples/strategy_in_evosax.py
"""

import jax
import jax.numpy as jnp

from mjxwalk.strategies import snes, to_evosax

solution = jnp.ones(10)
algorithm = to_evosax(snes(population_size=32, sigma=0.5), solution)
params = algorithm.default_params

key, key_init = jax.random.split(jax.random.key(0))
state = algorithm.init(key_init, solution, params)
ask, tell = jax.jit(algorithm.ask), jax.jit(algorithm.tell)
for key_ask, key_tell in jax.random.split(key, (100, 2)):
    population, state = ask(key_ask, state, params)
    state, metrics = tell(key_tell, population, (population**2).sum(1), state, params)
print(f"smallest sum of squares {metrics['best_fitness']:.2e}")
