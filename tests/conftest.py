"""Readies JAX as the command line does, with two CPU devices whatever the machine has."""

from collections.abc import Iterator

import jax
import jaxtyping
import pytest
from hypothesis import HealthCheck, settings

from mjxwalk import engines
from mjxwalk.strategies import registry

jax.config.update("jax_num_cpu_devices", 2)
engines.prepare()

# The same few examples every time; `--hypothesis-profile=thorough` takes others, and many of them.
UNHURRIED = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much]
settings.register_profile(
    "few", max_examples=5, derandomize=True, database=None, deadline=None,
    suppress_health_check=UNHURRIED,
)  # fmt: skip
settings.register_profile(
    "thorough", max_examples=250, database=None, deadline=None, print_blob=True,
    suppress_health_check=UNHURRIED,
)  # fmt: skip
settings.load_profile("few")


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
