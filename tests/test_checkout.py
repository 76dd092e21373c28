"""Tests that a checkout in which git made no symbolic links is the whole package."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
WITHOUT = "import sys, pathlib; sys.path.insert(0, sys.argv.pop(1))\n"


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clone without links, with the package as it is here."""
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("no git, or no clone")
    path = tmp_path_factory.mktemp("clone") / "checkout"
    clone = ["git", "clone", "-q", "--no-hardlinks", "-c", "core.symlinks=false", ROOT, path]
    subprocess.run(clone, check=True, timeout=120)
    for part in ("mjxwalk", "envs", "strategies"):  # with what is not committed yet
        for file in (ROOT / part).rglob("*.py"):
            copied = path / file.relative_to(ROOT)
            copied.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, copied)
    return path


def run(checkout: Path, program: str, *args: str) -> str:
    """Returns what a program prints that imports from the checkout."""
    command = [sys.executable, "-c", WITHOUT + program, str(checkout), *args]
    done = subprocess.run(
        command, cwd=checkout.parent, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_both_folders_are_parts_of_the_package(checkout: Path) -> None:
    assert not any((checkout / "mjxwalk" / name).is_dir() for name in ("envs", "strategies"))
    program = "import mjxwalk.envs as e, mjxwalk.strategies as s; print(e.__file__, s.__file__)\n"
    program += "from mjxwalk import own_process; print(all(map(own_process.is_ours, "
    program += "(e.__file__, s.__file__))))"
    envs, strategies = (checkout / name / "__init__.py" for name in ("envs", "strategies"))
    assert run(checkout, program) == f"{envs} {strategies}\nTrue\n"


@pytest.mark.parametrize("name", ["tests", "scripts", "docs", "web", "mjxwalk"])
def test_no_other_folder_of_the_checkout_is(name: str, checkout: Path) -> None:
    program = f"import importlib.util as i; print(i.find_spec('mjxwalk.{name}'))"
    assert run(checkout, program) == "None\n"


@pytest.mark.parametrize("args", [["--help"], ["list"]], ids=" ".join)
def test_the_program_runs(args: list[str], checkout: Path) -> None:
    program = "import mjxwalk.cli; sys.argv[0] = 'mjxwalk'; sys.exit(mjxwalk.cli.program())"
    assert run(checkout, program, *args)
