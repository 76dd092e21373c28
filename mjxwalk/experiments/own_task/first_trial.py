"""Runs single walkers of a user's task to the end of their trials, if there is one."""

from typing import Any

import jax
import jax.numpy as jnp

from mjxwalk.errors import RunError
from mjxwalk.experiments.experiment import Experiment
from mjxwalk.rollout import advance, start

CHUNK = 1000  # steps between looks whether a trial has ended; ours


class FirstTrial:
    """A trial that walkers are given one after the other, compiled once."""

    def __init__(self, place: str, experiment: Experiment, given: Any) -> None:
        env, controller = experiment.env, experiment.controller
        self._place = place  # of `step`, for the complaint
        self._begin = jax.jit(lambda genotype: start(env, controller, genotype, given))

        def proceed(genotype: Any, walk: Any, most: Any) -> Any:
            def walking(at: Any) -> Any:
                return (at[0] < most) & ~at[1].state.trial.done

            def step(at: Any) -> Any:
                return at[0] + 1, advance(env, controller, genotype, given, at[1])

            return jax.lax.while_loop(walking, step, (jnp.zeros((), jnp.int32), walk))

        self._proceed = jax.jit(proceed)

    def run(self, genotype: Any, most_steps: int) -> Any:
        """Returns the walker at the end of its trial.

        Raises:
          RunError: it has no end within so many steps.
        """
        walk, steps = self._begin(genotype), 0
        while not bool(walk.state.trial.done):
            if steps == most_steps:
                raise RunError(
                    f"{self._place}: a trial has not ended after "
                    f"{steps:,} steps; let state.trial.done become true at some time, or give "
                    "--most-steps if trials are that long"
                )
            most = min(CHUNK, most_steps - steps)
            taken, walk = self._proceed(genotype, walk, most)
            steps += int(taken)
        return walk
