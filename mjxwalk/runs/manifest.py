"""Where a run took place, as the file `manifest.json`: explains a difference, repeats nothing."""

import importlib.metadata
import os
import platform
import subprocess
from pathlib import Path
from typing import Any

import msgspec

import mjxwalk
from mjxwalk.runs import digests, files, owner

FILE = "manifest.json"
PACKAGES = (
    "jax",
    "jaxlib",
    "mujoco",
    "mujoco-mjx",
    "numpy",
    "optax",
    "orbax-checkpoint",
    "llvmlite",
)


class _Known(msgspec.Struct):
    """What others rely on; older versions wrote less, and newer ones may write more."""

    mjxwalk: str = ""
    commit: str | None = None
    python: str = ""
    packages: dict[str, str | None] = {}
    engine: str = ""
    devices: str = ""
    cpu: str = ""
    system: str = ""


def write(folder: Path, *, engine: str, why: str, devices: str, settings: dict[str, Any]) -> None:
    """Writes the manifest of a run that starts now.

    Args:
      folder: of the run.
      engine: that evaluates.
      why: the reason for this engine.
      devices: that it runs on, in words.
      settings: of JAX's that results depend on, by name.

    Raises:
      RunError: it cannot be written.
    """
    data: dict[str, Any] = {
        "mjxwalk": mjxwalk.__version__,
        "commit": git_commit(),
        "python": platform.python_version(),
        "packages": versions(),
        "engine": engine,
        "why": why,
        "devices": devices,
        "settings": settings,
        "cpu": cpu_model(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
    }
    files.replace(folder, FILE, owner.with_digest(folder, data))


def versions() -> dict[str, str | None]:
    """Returns the versions of the packages that a result can depend on, None where missing."""
    found: dict[str, str | None] = {}
    for package in PACKAGES:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = None
    return found


def cpu_model() -> str:
    """Returns the processor's name, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def git_commit() -> str | None:
    """Returns the commit of the checkout that mjxwalk runs from, "+" if changed; else None."""
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return None
    try:
        commit = _git(root, "rev-parse", "HEAD")
        changed = _git(root, "status", "--porcelain", "--untracked-files=no")
    except (OSError, subprocess.SubprocessError):
        return None
    return commit + ("+" if changed else "")


def _git(root: Path, *args: str) -> str:
    command = ["git", "-C", str(root), *args]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True, timeout=10)
    return done.stdout.strip()


def read(folder: Path) -> dict[str, Any]:
    """Returns the manifest of a run, {} if it was never written.

    Raises:
      RunError: the file cannot be read, was changed, or is of another run.
    """
    content = owner.read(folder, FILE)
    if content is None:
        return {}
    files.decode(folder / FILE, content, _Known)
    data = files.decode_table(folder / FILE, content)
    return {name: value for name, value in data.items() if name not in (digests.DIGEST, owner.RUN)}


def engine(folder: Path, otherwise: str) -> str:
    """Returns the engine that a run was begun with, or another name where that is not known.

    Raises:
      RunError: the manifest cannot be read, or was changed.
    """
    return str(read(folder).get("engine", otherwise))
