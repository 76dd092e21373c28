"""Tests of who imports whom, as the contracts in pyproject.toml have it."""

from pathlib import Path

import grimp
from importlinter import cli

CONTRACTS = Path(__file__).parents[1] / "pyproject.toml"


def test_every_module_imports_from_below_it_alone() -> None:
    status = cli.lint_imports(config_filename=str(CONTRACTS), no_cache=True)
    assert status == cli.EXIT_STATUS_SUCCESS


def test_bodies_and_strategies_are_looked_at_too() -> None:
    modules = grimp.build_graph("mjxwalk", cache_dir=None).modules
    assert {"mjxwalk.envs.terrain", "mjxwalk.strategies.cma_es"} <= modules
