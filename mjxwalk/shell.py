"""Commands that a user can type as they are shown."""

import shlex
from pathlib import Path


def command(*words: str | Path) -> str:
    """Returns a command of mjxwalk, quoted so that a shell takes each word as it is.

    Args:
      words: what follows the program's name; a `Path` is never taken for an option.
    """
    return " ".join(["mjxwalk", *map(quoted, words)])


def quoted(word: str | Path) -> str:
    """Returns a word as a shell needs it; a path that begins with a dash gets ./ before it."""
    text = str(word)
    if isinstance(word, Path) and text.startswith("-"):
        text = f"./{text}"
    if text.isprintable():
        return shlex.quote(text)
    # What no terminal shows as it is: control characters, and bytes that are no text.
    return f"$'{''.join(_escaped(letter) for letter in text)}'"


def _escaped(letter: str) -> str:
    if letter in "\\'":
        return f"\\{letter}"
    if letter.isprintable():
        return letter
    # In octal, which ends after three digits; digits of the name may follow.
    return "".join(f"\\{byte:03o}" for byte in letter.encode(errors="surrogateescape"))
