"""What a user has to be told, each in one sentence that says what to do."""

import difflib
from collections.abc import Iterable


class RunError(Exception):
    """An argument, a run folder, its settings or its files cannot be used."""


class Interrupted(Exception):
    """The run was asked to stop, and everything that it had finished is saved."""


def near(name: str, names: Iterable[str]) -> str:
    """Returns "; did you mean ...?" with the names closest to a wrong one, else all of them."""
    known = sorted(names)
    close = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
    if close:
        return f"; did you mean {' or '.join(close)}?"
    return f"; there is {', '.join(known)}" if known else ""
