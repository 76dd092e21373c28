"""Readies JAX as the command line does, with two CPU devices whatever the machine has."""

from collections.abc import Iterator

import jax
import jaxtyping
import pytest

from mjxwalk import engines
from mjxwalk.strategies import registry

jax.config.update("jax_num_cpu_devices", 2)
engines.prepare()


@pytest.fixture(autouse=True)
def _own_strategies_stay_in_their_test() -> Iterator[None]:
    """Takes back the strategies that a test registers, which others would be told of."""
    before = dict(registry._factories)  # pyright: ignore[reportPrivateUsage]
    yield
    registry._factories.clear()  # pyright: ignore[reportPrivateUsage]
    registry._factories.update(before)  # pyright: ignore[reportPrivateUsage]


@pytest.fixture
def unchecked_types() -> Iterator[None]:
    """Lets a wrong type through to our own checks, as it gets through outside the tests."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)
