"""Tests that the package does without what Windows lacks, in a process from which it was taken."""

import subprocess
import sys
from pathlib import Path

import toy

# What other packages import stays with them.
TAKE = """
import asyncio, os, pkgutil, shutil, signal, subprocess, sys, tempfile, threading
import jax, jinja2, matplotlib.pyplot, mujoco.mjx, optax, orbax.checkpoint, pandas, portalocker
import msgspec, rich.live, tyro, waitress
from importlib.util import find_spec
for extra in ("gymnasium", "onnx", "imageio_ffmpeg", "safetensors", "tensorboardX"):
    if find_spec(extra):
        __import__(extra)
jax.devices()

for name in ("fcntl", "resource", "termios", "tty", "pwd", "grp"):
    sys.modules[name] = None
for name in (
    "O_NOFOLLOW O_NONBLOCK O_DIRECTORY O_NOCTTY O_CLOEXEC fork register_at_fork getuid geteuid "
    "getgid sysconf fchmod getloadavg sched_getaffinity sched_setaffinity killpg"
).split():
    delattr(os, name)
for name in ("SIGHUP", "SIGKILL", "SIGPIPE"):
    delattr(signal, name)


def without_folders(name):
    function = getattr(os, name)

    def called(*args, **options):
        if any(options.get(each) is not None for each in ("dir_fd", "src_dir_fd", "dst_dir_fd")):
            raise NotImplementedError(f"os.{name} relative to a folder")
        if name == "open" and os.path.isdir(args[0]):
            raise PermissionError(13, "Permission denied")
        return function(*args, **options)

    setattr(os, name, called)


for name in ("open", "stat", "mkdir", "unlink", "rmdir", "replace", "rename"):
    without_folders(name)
os.supports_dir_fd.clear()
shutil._use_fd_functions = False
"""

IMPORT_ALL = """
import mjxwalk
broken = []
for module in pkgutil.walk_packages(mjxwalk.__path__, "mjxwalk.", broken.append):
    if not module.name.endswith("__main__"):
        __import__(module.name)
assert not broken, broken
for name in ("mjxwalk.envs", "mjxwalk.runs.locking", "mjxwalk.strategies.openai_es"):
    assert name in sys.modules, name
"""

EVOLVE = """
sys.path.insert(0, sys.argv[1])
from pathlib import Path

import pytest, toy
from mjxwalk.cli import main
from mjxwalk.runs import locking, way

assert not way.OPENS_FOLDERS
with pytest.MonkeyPatch.context() as patch:
    toy.install(patch)
    assert main(["evolve", "--generations", "4", "--out", "run"]) == 0
    assert main(["list", "--runs", "."]) == 0
    champion = Path("run/champion.npz").read_bytes()
    for path in ("run/champion.npz", "run/result.json"):
        os.unlink(path)
    shutil.rmtree("run/checkpoints/4")
    with locking.locked(Path("run")):
        assert main(["resume", "run"]) == 2
    assert main(["resume", "run"]) == 0
    assert Path("run/champion.npz").read_bytes() == champion
    os.unlink("run/result.json")
    os.rename("run/checkpoints", "elsewhere")
    os.symlink("../elsewhere", "run/checkpoints")
    assert main(["resume", "run"]) == 2
"""


def run(program: str, folder: Path) -> str:
    """Returns what a program says that runs where Windows' lacks are made."""
    command = [sys.executable, "-c", TAKE + program, str(Path(toy.__file__).parent)]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stderr


def test_every_module_can_be_imported(tmp_path: Path) -> None:
    run(IMPORT_ALL, tmp_path)


def test_a_run_evolves_resumes_is_locked_and_follows_no_link(tmp_path: Path) -> None:
    told = run(EVOLVE, tmp_path)
    assert "another process is working on run" in told
    assert "run/checkpoints is a link" in told
