"""Every body's rollout becomes a program for GPUs and for TPUs, on a machine that has neither.

`jax.export` translates to StableHLO, in which accelerators differ by a few calls; that their own
compilers take it is not shown.
"""

import re

import jax
import pytest
from engines.rollouts import BODIES, shapes
from jax import export

from mjxwalk.engines import lanes_xla
from mjxwalk.envs import TRIAL_AXES

PLATFORMS = ("cuda", "tpu")
WALKERS = 4
ENGINES = {"mjx": lambda function: function, "lanes-xla": lanes_xla.scalarised}
QUICK = (("planar7", "lanes-xla"),)
ALL = [(body, engine) for body in BODIES for engine in ENGINES]
CASES = [pair if pair in QUICK else pytest.param(*pair, marks=pytest.mark.slow) for pair in ALL]


@pytest.mark.parametrize(("body", "engine"), CASES)
def test_a_rollout_becomes_a_program_for_gpus_and_tpus(body: str, engine: str) -> None:
    experiment = BODIES[body]()
    population, trials = shapes(experiment, WALKERS)
    rollout = jax.jit(jax.vmap(ENGINES[engine](experiment.rollout), (0, TRIAL_AXES)))
    exported = export.export(rollout, platforms=PLATFORMS)(population, trials)
    text = exported.mlir_module()
    assert exported.platforms == PLATFORMS
    assert all(shape.shape[0] == WALKERS for shape in exported.out_avals)
    assert "stablehlo.while" in text
    assert "f64" not in text  # which TPUs lack
    # A GPU's Cholesky factorisation is a library's, which JAX brings along with its plugin.
    calls = set(re.findall(r"custom_call @(\w+)", text))
    assert calls <= ({"cusolver_potrf_ffi"} if engine == "mjx" else set())
