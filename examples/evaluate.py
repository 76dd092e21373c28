"""Evaluates random linear policies of the planar walker: every genotype in every trial.

python examples/evaluate.py
"""

import jax

from mjxwalk import experiments
from mjxwalk.controllers import LinearReactive
from mjxwalk.evaluation import evaluate

env = experiments.get("planar-lpd").env
controller = LinearReactive(links="all")
key_genotypes, key_trials = jax.random.split(jax.random.key(0))
genotypes = jax.tree.map(
    lambda leaf: 0.3 * jax.random.normal(key_genotypes, (1000, *leaf.shape)), controller.template()
)
outcome = evaluate(env, controller, genotypes, env.sample_trials(key_trials, 4))
print(f"{outcome.distance.shape} trials, the farthest {outcome.distance.max():.2f} m")
