"""Readies JAX as the command line does, with two CPU devices whatever the machine has."""

from collections.abc import Iterator

import jax
import jaxtyping
import pytest

from mjxwalk import engines

jax.config.update("jax_num_cpu_devices", 2)
engines.prepare()


@pytest.fixture
def unchecked_types() -> Iterator[None]:
    """Lets a wrong type through to our own checks, as it gets through outside the tests."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)
