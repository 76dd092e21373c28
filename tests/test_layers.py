"""Tests of who imports whom, as the contracts in pyproject.toml have it, and who knows bodies."""

import re
from collections.abc import Iterator
from pathlib import Path

import grimp
import pytest
from importlinter import cli

from mjxwalk.envs import BODIES

ROOT = Path(__file__).parents[1]
CONTRACTS = ROOT / "pyproject.toml"
KNOW_BODIES = ("envs", "experiments", "robots")  # of the package; robots are data
AUTHORS = re.compile(r"Reil & Massey")  # whose name a body has
NAMES = re.compile(rf"\b({'|'.join(BODIES)}|envs\.bodies|envs import bodies)\b")


def test_every_module_imports_from_below_it_alone() -> None:
    status = cli.lint_imports(config_filename=str(CONTRACTS), no_cache=True)
    assert status == cli.EXIT_STATUS_SUCCESS


def test_bodies_and_strategies_are_looked_at_too() -> None:
    modules = grimp.build_graph("mjxwalk", cache_dir=None).modules
    assert {"mjxwalk.envs.terrain", "mjxwalk.strategies.cma_es"} <= modules


def sources() -> Iterator[Path]:
    """Returns the files of the package and of the scripts that may know no body."""
    for folder in ("mjxwalk", "scripts"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            if path.relative_to(ROOT / folder).parts[0] not in KNOW_BODIES:
                yield path


def named(text: str) -> list[str]:
    """Returns the lines that name a body or import one."""
    return [line for line in AUTHORS.sub("", text).splitlines() if NAMES.search(line)]


def test_no_tool_knows_a_body_by_name() -> None:
    found = {
        f"{path.relative_to(ROOT)}: {line.strip()}"
        for path in sources()
        for line in named(path.read_text(encoding="utf-8"))
    }
    assert not found


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("from mjxwalk.envs import LeggedEnv", 0),
        ("After Reil & Massey (2001).", 0),
        ("isinstance(env, Planar7)", 1),
        ('"""Returns the foot of `Flame`."""', 1),
        ("from mjxwalk.envs.bodies import planar7_body", 1),
        ("from mjxwalk.envs import bodies", 1),
        ("Reil & Massey's body, Reil, and\nFlame", 2),
    ],
)
def test_a_body_that_is_named_is_found(text: str, lines: int) -> None:
    assert len(named(text)) == lines
