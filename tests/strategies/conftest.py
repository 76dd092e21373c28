"""Compiles the strategies' small programs quickly: they run for less time than they compile."""

from pathlib import Path

import jax
import pytest

HERE = Path(__file__).parent


# Hooks and no fixture: one of this folder, which is no package, would end with the whole session,
# and one of each module would have the next compile anew what all of them use.
@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Compiles quickly from here on."""
    jax.config.update("jax_disable_most_optimizations", True)


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """Compiles well again after the last test of this folder."""
    if nextitem is None or HERE not in nextitem.path.parents:
        jax.config.update("jax_disable_most_optimizations", False)
        jax.clear_caches()  # what was compiled so rounds otherwise
