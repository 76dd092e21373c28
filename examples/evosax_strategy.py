"""Evolves a perceptron with a strategy of evosax, in mjxwalk's own ask and tell.

pip install evosax
python examples/evosax_strategy.py
"""

import jax
from evosax.algorithms import CR_FM_NES

from mjxwalk import experiments
from mjxwalk.controllers import Mlp
from mjxwalk.evaluation import evaluate
from mjxwalk.strategies import from_evosax

env = experiments.get("planar-lpd+mlp").env
controller = Mlp(hidden=(8,)).on(env)
template = controller.template()
algorithm = CR_FM_NES(population_size=64, solution=template)
strategy = from_evosax(algorithm, algorithm.default_params.replace(std_init=0.03))

key_init, *keys = jax.random.split(jax.random.key(0), 6)
state = strategy.init(key_init, template)
for generation, key in enumerate(keys, start=1):
    key_ask, key_trials, key_tell = jax.random.split(key, 3)
    population, state = strategy.ask(key_ask, state)
    outcome = evaluate(env, controller, population, env.sample_trials(key_trials, 1))
    fitness = outcome.fitness.mean(axis=1)
    state, _ = strategy.tell(key_tell, population, fitness, state)
    print(f"generation {generation}: fitness {fitness.max():.2f}, {outcome.distance.max():.2f} m")
