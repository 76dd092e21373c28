"""The command line on the toy, in a process of its own."""

import os
import subprocess
import sys
import time
from pathlib import Path

import toy

TOY = Path(toy.__file__)


def start(*args: str) -> subprocess.Popen[str]:
    """Starts the command line on the toy in a process of its own."""
    return subprocess.Popen(
        [sys.executable, str(TOY), *args],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )


def wait_for_lines(path: Path, number: int) -> None:
    deadline = time.monotonic() + 300
    while not path.exists() or path.read_bytes().count(b"\n") < number:
        assert time.monotonic() < deadline, f"{path} has not got {number} lines in five minutes"
        time.sleep(0.01)
