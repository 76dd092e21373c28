"""Whole trials in C MuJoCo: what a walker senses, what drives it, and what ends its trial.

Independent of the engine that evolved the walker: senses, counters and the rules of a trial are
written once more, in float64. Shared with it: the source of the controller, which says what the
walker is, though JAX compiles it here for float64; and where a trial starts, which is data.
"""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from mjxwalk.envs import TRIAL_AXES, Anatomy, LeggedEnv, Trials, targets
from mjxwalk.rollout import Controller, Outcome
from mjxwalk.verify import laws
from mjxwalk.verify.mj_step import MjStep
from mjxwalk.verify.reference import Reference
from mjxwalk.verify.rules import Rules
from mjxwalk.verify.senses import Senses


def run(env: LeggedEnv, controller: Controller, genotype: Any, trials: Trials) -> Outcome:
    """Returns what one genotype does in each trial, as float64 numpy arrays [walker].

    Args:
      env: body, ground and rules of the trials.
      controller: what the genotype becomes.
      genotype: of the one walker.
      trials: one of each walker.
    """
    reset = jax.jit(jax.vmap(env.reset, in_axes=(TRIAL_AXES,)))
    starts = reset(trials.given(np.arange(trials.num)))
    like = jax.eval_shape(env.observe, jax.tree.map(lambda leaf: leaf[0], starts))
    # JAX keeps what it traced with 32 bits for an engine, and takes it for the 64 bits here.
    jax.clear_caches()
    reference = _kind(env)(env, starts.qpos, starts.qvel, trials)
    reference.stretch[:] = np.reshape(starts.stretch, reference.stretch.shape)
    rules = Rules(reference, starts.touching, starts.ankle_x)
    senses, moved = Senses(reference.anatomy, like), _moved(env)
    with jax.enable_x64(True), jax.default_device(jax.devices("cpu")[0]):
        double: Any = jax.tree.map(lambda leaf: np.asarray(leaf, np.float64), genotype)
        act = _acting(controller, double, moved)
        memory = _repeated(jax.jit(controller.init)(double), trials.num)
        walking = np.ones(trials.num, bool)
        while walking.any():
            # All are shown to the controller, those at rest too: another number compiles anew.
            memory, action = act(memory, senses.of(reference.qpos, reference.qvel, rules.sensed()))
            before = reference.qpos, reference.qvel
            step = reference.step(action, walking)
            walking &= ~rules.judge(walking, step, before, action)
    tally = rules.tally
    return Outcome(
        fitness=rules.fitness(),
        distance=rules.x.copy(),
        duration=tally.steps * env.timestep,
        fell=tally.fell,
        diverged=tally.diverged,
        torque_cost=tally.torque_cost,
        work=tally.work,
        steps=tally.steps,
    )


def _kind(env: LeggedEnv) -> type[Reference]:
    """Returns what steps a body in C MuJoCo: MuJoCo itself, under its own contact law."""
    return MjStep if getattr(env, "contact_law", "points") == "mujoco" else Reference


def _moved(env: LeggedEnv) -> Anatomy:
    """Returns the anatomy whose motors say what numbers from -1 to 1 ask for.

    Where a policy gives targets to one of our bodies, these are others than the body has.
    """
    gives_targets = getattr(env, "acting", "torque") == "target"
    if gives_targets and env.anatomy.motors[0].law == "torque":
        return targets.holding(env)
    return env.anatomy


def _acting(controller: Controller, genotype: Any, anatomy: Anatomy) -> Callable[..., Any]:
    """Returns a function from memory and senses to the next memory, and what is asked of motors.

    That is an array [field, walker, motor], with the fields of the motors' law.
    """

    def acted(memory: Any, seen: Any) -> Any:
        memory, action = controller.act(genotype, memory, seen)
        if not isinstance(action, tuple):
            return memory, action
        return memory, jnp.stack(action)  # in one piece, as each costs a copy

    mapped = jax.jit(jax.vmap(acted))

    def act(memory: Any, seen: Any) -> Any:
        memory, action = mapped(memory, seen)
        asked = np.asarray(action)
        if asked.ndim == 2:
            return memory, np.stack(laws.of_numbers(anatomy, asked))
        return memory, np.moveaxis(asked, 1, 0)

    return act


def _repeated(memory: Any, num: int) -> Any:
    return jax.tree.map(lambda leaf: np.repeat(np.asarray(leaf)[None], num, axis=0), memory)
