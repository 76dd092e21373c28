"""A walker's step of control as a function of arrays by name: what goes in, and what comes out."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import numpy as np

from mjxwalk.envs import LeggedEnv
from mjxwalk.errors import RunError
from mjxwalk.export import tracing
from mjxwalk.runs.trees import flatten
from mjxwalk.walker import Walker

MEMORY = "memory."  # what it remembers may be called like a sense
NEXT = "next."  # in place of MEMORY, of what comes out to be remembered
OBSERVATION, ACTION = "observation", "action"  # of a task whose walkers sense an array of numbers


class Step(NamedTuple):
    """A step of control.

    Attributes:
      senses: what goes in at each step, as at the start of a trial.
      memory: what is remembered from one step to the next, as it starts; its names start with
        MEMORY. What no action depends on, such as what is counted for the evolution, is left out.
      run: takes senses and memory by name, and returns the action by name, as the motors take it,
        and the memory of the next step, `next.NAME` of `memory.NAME`.
    """

    senses: dict[str, Any]
    memory: dict[str, Any]
    run: Callable[..., dict[str, Any]]


def of(walker: Walker) -> Step:
    """Returns the step of a walker's controller.

    Raises:
      RunError: its environment says nothing of its observations and actions.
    """
    env, controller = walker.experiment.env, walker.experiment.controller
    senses = sensed(env)
    start = controller.init(walker.genotype)
    every = {f"{MEMORY}{name}": leaf for name, leaf in flatten(start).items()}

    def step(**values: Any) -> dict[str, Any]:
        memory = [values.get(name, np.asarray(leaf)) for name, leaf in every.items()]
        before = jax.tree.unflatten(jax.tree.structure(start), memory)
        seen = put_together(env, {name: values[name] for name in senses})
        after, action = controller.act(walker.genotype, before, seen)
        remembered = dict(zip(every, jax.tree.leaves(after), strict=True))
        return _asked(env, action) | {_next(name): remembered[name] for name in every}

    needed = _needed(tracing.reads(step, shapes(senses | every)), list(every))

    def run(**values: Any) -> dict[str, Any]:
        left_out = {_next(name) for name in every if name not in needed}
        found = step(**values)
        return {name: value for name, value in found.items() if name not in left_out}

    return Step(senses, {name: every[name] for name in needed}, run)


def check(source: object, experiment: Any) -> None:
    """Raises RunError unless it can be told what an experiment's controllers sense and give.

    Args:
      source: where a walker is from, for the error.
      experiment: that it evolved in.
    """
    env = experiment.env
    if not isinstance(env, LeggedEnv) and not is_task(env):
        raise RunError(
            f"{source} has the environment {type(env).__name__}, which does not say what its "
            "walkers sense and move; give it observation_names and action_names, or derive it from "
            "mjxwalk.envs.LeggedEnv"
        )


def is_task(env: Any) -> bool:
    """Returns whether an environment's walkers sense and give named numbers, without a body."""
    return hasattr(env, "observation_names") and hasattr(env, "action_names")


def observation_of(env: Any) -> Any:
    """Returns what a walker senses at the start of a trial, on level ground if it has a body."""
    if is_task(env):
        return env.observe(env.reset(env.sample_trials(jax.random.key(0), 1).given(0)))
    return env.observe(env.reset(env.level_trials().given(0)))


def sensed(env: Any) -> dict[str, Any]:
    """Returns the fields of `observation_of` that the body has, by name."""
    observation = observation_of(env)
    if is_task(env):
        return {OBSERVATION: observation}
    return {name: leaf for name, leaf in observation._asdict().items() if leaf is not None}


def put_together(env: Any, values: dict[str, Any]) -> Any:
    """Returns the observation of which `sensed` gives the parts."""
    return values[OBSERVATION] if is_task(env) else observation_of(env)._replace(**values)


def shapes(arrays: dict[str, Any]) -> dict[str, Any]:
    """Returns shapes and types of arrays by name."""
    return {name: jax.ShapeDtypeStruct(leaf.shape, leaf.dtype) for name, leaf in arrays.items()}


def _asked(env: Any, action: Any) -> dict[str, Any]:
    """Returns an action by name; numbers from -1 to 1 of a body as its motors take them."""
    if is_task(env):
        return {ACTION: action}
    asked: Any = action if isinstance(action, tuple) else env.scaled_action(action)
    return asked._asdict()


def _next(name: str) -> str:
    return f"{NEXT}{name.removeprefix(MEMORY)}"


def _needed(reads: dict[str, set[str]], memory: list[str]) -> list[str]:
    """Returns the memory that actions depend on, in this step or a later one.

    Args:
      reads: names of what goes in, of each that comes out.
      memory: all of its names.
    """
    found: set[str] = set().union(*(of for name, of in reads.items() if not name.startswith(NEXT)))
    while True:
        more = found.union(*(reads[_next(name)] for name in memory if name in found))
        if more == found:
            return [name for name in memory if name in found]
        found = more
