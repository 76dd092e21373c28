"""Tells processes that were forked after JAX had begun to compute; there it would hang.

A fork has none of the threads of the process that it came from, and JAX waits for its own.
"""

import os
import threading

from jax._src import xla_bridge  # no public way to ask whether JAX has begun; JAX 0.10

from mjxwalk.errors import ForkedError

_IS_STUCK = threading.Event()


def check() -> None:
    """Raises ForkedError in a process that was forked after JAX had begun to compute."""
    if _IS_STUCK.is_set():
        raise ForkedError(
            "this process was forked after JAX had begun to compute, and JAX would hang in it; "
            "start processes by spawn: AsyncVectorEnv(..., context='spawn'), make_vec(..., "
            "vector_kwargs={'context': 'spawn'}) or multiprocessing.get_context('spawn')"
        )


def _note() -> None:
    if xla_bridge.backends_are_initialized():
        _IS_STUCK.set()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note)
