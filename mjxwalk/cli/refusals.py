"""What the machine, the system or JAX refused, as one sentence for the user."""

import os
import sys

from mjxwalk.errors import RunError, first_line, outgrown
from mjxwalk.experiments import own_task


def sentence(error: Exception) -> str | None:
    """Returns what to tell the user, None of an error that is a fault of ours."""
    if isinstance(error, RunError):
        return str(error)
    in_task = own_task.located(error)
    if in_task is not None:
        return in_task
    if isinstance(error, OSError):
        if not _has_folder():
            return "the folder that this shell is in is no longer there; change to another"
        reason = (error.strerror or str(error)).lower()
        return f"{error.filename or 'the output'} cannot be used: {reason}"
    if isinstance(error, ImportError):
        return f"a library cannot be loaded: {error}"
    if type(error).__name__ == "CannotCompileError":  # of an engine, not imported for its name
        return str(error)
    told = outgrown(error)
    if told is not None or "jax" not in sys.modules:
        return told
    from mjxwalk.engines import pinning

    if type(error).__name__ == "JaxRuntimeError":
        return f"JAX cannot go on: {first_line(error)}"
    return pinning.why_not_started(error)


def _has_folder() -> bool:
    try:
        os.getcwd()
    except OSError:
        return False
    return True
