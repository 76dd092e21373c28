"""Makes the process of a command independent of the shell that started it.

What is done here is done to the whole process, so only a process that runs one command and ends
does it: `cli.main` and `cli.run` that read their arguments from `sys.argv`.
"""

import os
import signal
import sys
import warnings
from types import FrameType

from mjxwalk import budget
from mjxwalk.cli.signals import SIGNALS, leave
from mjxwalk.errors import RunError

# Variables of JAX's that say where it computes, and none of which changes a number. Any other is
# left out: it is an option of JAX's, which may change numbers, stop a command or be nonsense.
JAX_MAY_KNOW = (
    "JAX_PLATFORMS",
    "JAX_PLATFORM_NAME",
    "JAX_CUDA_VISIBLE_DEVICES",
    "JAX_ROCM_VISIBLE_DEVICES",
    "JAX_COMPILATION_CACHE_DIR",
    "JAX_COORDINATOR_ADDRESS",
    "JAX_COORDINATOR_BIND_ADDRESS",
    "JAX_COORDINATOR_PORT",
    "JAX_LOCAL_DEVICE_IDS",
    "JAX_PARTITION_INDEX",
    "JAX_SLICE_INDEX",
    "JAX_DUMP_IR_TO",
)
# Others that JAX, XLA, MJX and NumPy's and SciPy's linear algebra read, and compute otherwise.
COMPUTING = (
    "CHECK_VMA",
    "EAGER_CONSTANT_FOLDING",
    "LIBTPU_INIT_ARGS",
    "MJXWALK_LANES_WIDTH",  # for trials of the engine from Python
    "MJX_GPU_DEFAULT_WARP",
    "MJX_WARP_ENABLED",
    "MOCK_NUM_GPU_PROCESSES",
    "NPY_DISABLE_CPU_FEATURES",
    "NPY_ENABLE_CPU_FEATURES",
    "NVIDIA_TF32_OVERRIDE",
    "OPENBLAS_CORETYPE",
    "XLA_FLAGS",
)
FEWEST_ADDRESSES = 2_000_000_000  # bytes; ours: with 1.6 GB the libraries of JAX abort on two cores
# Left out without a word: a notebook sets them for all that it starts.
DRAWING = ("MATPLOTLIBRC", "MPLBACKEND")


def own() -> list[str]:
    """Readies this process for one command, and returns which variables were left out.

    Comes before JAX, NumPy and matplotlib are imported, since they read the environment then.
    """
    _open_streams()
    _warn_as_usual()
    for name in DRAWING:
        os.environ.pop(name, None)
    left_out = sorted(filter(is_left_out, os.environ))
    for name in left_out:
        del os.environ[name]
    return left_out


def is_left_out(name: str) -> bool:
    """Returns whether a variable of the environment would change what is computed."""
    is_jax = name.startswith(("JAX_", "JAX2TF_"))
    return name in COMPUTING or (is_jax and name not in JAX_MAY_KNOW)


def check_memory() -> None:
    """Raises RunError unless the process may have the addresses that JAX aborts without."""
    if sys.platform != "linux":
        return
    limit = budget.limit("RLIMIT_AS")
    if limit < FEWEST_ADDRESSES:
        raise RunError(
            f"`ulimit -v` leaves {limit / 1e9:.2g} GB of addresses, and JAX needs "
            f"{FEWEST_ADDRESSES / 1e9:g} GB; raise the limit, or set `ulimit -d`"
        )


def _open_streams() -> None:
    """Opens what is closed, and lets the streams take every text.

    Where a stream is closed, the next file that any library opens gets its number, and with it
    what is meant for the terminal.
    """
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
    sys.stdin = sys.stdin or os.fdopen(0, encoding="utf-8", closefd=False)
    sys.stdout = sys.stdout or os.fdopen(1, "w", encoding="utf-8", closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, "w", encoding="utf-8", closefd=False)
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="backslashreplace")


def _warn_as_usual() -> None:
    """Sets Python's own filters of warnings, whatever PYTHONWARNINGS makes of them."""
    warnings.resetwarnings()
    for category in (
        DeprecationWarning,
        PendingDeprecationWarning,
        ImportWarning,
        ResourceWarning,
    ):
        warnings.simplefilter("ignore", category)


def raise_on_signals() -> None:
    """Makes Ctrl-C and SIGTERM raise KeyboardInterrupt with their number, so that work unwinds."""
    for number in SIGNALS:
        signal.signal(number, _raise)


def _raise(number: int, frame: FrameType | None) -> None:
    if is_importing(frame):
        leave(number, frame)
    raise KeyboardInterrupt(number)


def is_importing(frame: FrameType | None) -> bool:
    """Returns whether a module is being imported.

    An exception must not be raised there: libraries in C turn it into errors of their own.
    """
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False
