"""Compiles the strategies' small programs quickly: they run for less time than they compile."""

from collections.abc import Iterator

import jax
import pytest


# Not of the package: in a folder without __init__.py that would end with the whole session.
@pytest.fixture(autouse=True, scope="module")
def _quick_compilation() -> Iterator[None]:  # pyright: ignore[reportUnusedFunction] # pytest uses it
    jax.config.update("jax_disable_most_optimizations", True)
    yield
    jax.config.update("jax_disable_most_optimizations", False)
    jax.clear_caches()  # what was compiled so rounds otherwise
