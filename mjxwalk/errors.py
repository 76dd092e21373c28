"""What a user has to be told, each in one sentence that says what to do."""

import difflib
from collections.abc import Iterable


class RunError(Exception):
    """An argument, a run folder, its settings or its files cannot be used."""


class ForkedError(RunError, RuntimeError):
    """The process was forked from one in which JAX has threads, so that it cannot compute."""


class Interrupted(Exception):
    """The run was asked to stop, and everything that it had finished is saved."""


def near(name: str, names: Iterable[str]) -> str:
    """Returns the end of a sentence about a wrong name: the names closest to it, else all."""
    known = sorted(names)
    alike = {each.lower(): each for each in known}
    if name.lower() in alike:
        return f"; did you mean {alike[name.lower()]}?"
    close = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
    if close:
        return f"; did you mean {' or '.join(close)}?"
    return f"; known are {', '.join(known)}" if known else ""


def first_line(error: BaseException) -> str:
    """Returns the first line of what an error says, or its name if it says nothing."""
    lines = str(error).strip().splitlines()
    return lines[0][:200] if lines else type(error).__name__


def outgrown(error: BaseException) -> str | None:
    """Returns what to tell of an error by which memory or numbers ran out; None of any other.

    What a setting or an argument asks for is measured before it is taken; this is for the rest.
    """
    text = first_line(error)  # XLA goes on with tables of what it has
    if isinstance(error, MemoryError) or "RESOURCE_EXHAUSTED" in text:
        return (
            "this takes more memory than there is; ask for less, such as a smaller population, or "
            f"fewer terrains or trials: {text}"
        )
    if isinstance(error, OverflowError):
        return f"a setting or an argument is too large to compute with: {text}"
    if type(error).__module__.partition(".")[0] == "mujoco":
        return f"MuJoCo cannot go on: {text}"
    return None
