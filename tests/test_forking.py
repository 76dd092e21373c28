"""Tests of what is said in processes that were forked after JAX had begun to compute."""

import multiprocessing
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import engines, forking
from mjxwalk.engines import mjx
from mjxwalk.errors import ForkedError
from mjxwalk.evolution import Evolution

pytestmark = pytest.mark.filterwarnings("ignore:os.fork")


def in_a_fork(work: Any) -> str:
    """Returns the name of the error that something ends with in a forked process."""
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe()

    def run() -> None:
        try:
            work()
            theirs.send("none")
        except Exception as error:
            theirs.send(type(error).__name__)

    process = context.Process(target=run)
    process.start()
    try:
        return ours.recv() if ours.poll(30) else "hangs"
    finally:
        process.kill()
        process.join()


def test_doors_to_jax_are_closed_in_a_fork() -> None:
    jnp.ones(3).block_until_ready()
    triple = mjx.vmap(lambda x: x * 3)
    assert in_a_fork(engines.prepare) == "ForkedError"
    assert in_a_fork(lambda: triple(np.ones(4, np.float32))) == "ForkedError"
    evolution = Evolution.__new__(Evolution)
    assert in_a_fork(lambda: evolution.start(0)) == "ForkedError"
    assert in_a_fork(forking.check) == "ForkedError"
    forking.check()


def test_an_error_of_a_fork_is_both_ours_and_pythons() -> None:
    assert issubclass(ForkedError, RuntimeError)
