"""Every body's rollout becomes a program for GPUs and for TPUs, on a machine that has neither.

`jax.export` translates to StableHLO, in which accelerators differ by a few calls; that their own
compilers take it is not shown.
"""

import functools
import re
from typing import Any

import jax
import numpy as np
import pytest
from jax import export

from mjxwalk import experiments, robots
from mjxwalk.engines import lanes_xla
from mjxwalk.envs import TRIAL_AXES
from mjxwalk.envs.mjcf import reader
from mjxwalk.experiments import walk

PLATFORMS = ("cuda", "tpu")
WALKERS = 4
ENGINES = {"mjx": lambda function: function, "lanes-xla": lanes_xla.scalarised}


def of_file(name: str, law: str) -> Any:
    """Returns the experiment of a body that ships as a file, under a contact law."""
    return walk.with_contact(walk.of_body(reader.read(robots.path(name)).text), law)


BODIES: dict[str, Any] = {
    "planar7": functools.partial(experiments.get, "planar-lpd"),
    "flame": functools.partial(experiments.get, "solomon-3d"),
    "reil": functools.partial(experiments.get, "reil-unassisted"),
    "walker2d, points": functools.partial(of_file, "walker2d", "points"),
    "walker2d, mujoco": functools.partial(of_file, "walker2d", "mujoco"),
    "h1, points": functools.partial(of_file, "h1", "points"),
    "op3, mujoco": functools.partial(of_file, "op3", "mujoco"),
    "Hopper-v5": functools.partial(experiments.get, "gymnasium/Hopper-v5"),
    "Humanoid-v5": functools.partial(experiments.get, "gymnasium/Humanoid-v5"),
}
QUICK = (("planar7", "mjx"), ("planar7", "lanes-xla"), ("reil", "lanes-xla"), ("Hopper-v5", "mjx"))
ALL = [(body, engine) for body in BODIES for engine in ENGINES]
CASES = [pair if pair in QUICK else pytest.param(*pair, marks=pytest.mark.slow) for pair in ALL]


@pytest.mark.parametrize(("body", "engine"), CASES)
def test_a_rollout_becomes_a_program_for_gpus_and_tpus(body: str, engine: str) -> None:
    experiment = BODIES[body]()
    trials = experiment.sample_trials(jax.random.key(0), 2).given(np.zeros(WALKERS, np.int32))
    population = jax.tree.map(
        lambda leaf: jax.ShapeDtypeStruct((WALKERS, *leaf.shape), leaf.dtype), experiment.template()
    )
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
