"""Arguments to a command; what tyro has to complain of, in one sentence."""

import contextlib
import io
import re
from collections.abc import Sequence
from typing import TypeVar

import tyro

from mjxwalk.errors import RunError

T = TypeVar("T")


def parse(program: str, command: type[T], args: Sequence[str]) -> T:
    """Returns the command with its arguments; prints help and exits if they ask for that.

    Args:
      program: what the user typed so far, for the help and the complaints.
      command: a dataclass of arguments.
      args: what follows.

    Raises:
      RunError: the arguments are wrong.
    """
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            return tyro.cli(
                command, prog=program, args=args, config=(tyro.conf.FlagCreatePairsOff,)
            )
    except SystemExit as stop:
        if not stop.code:
            raise
        raise RunError(f"{sentence(complaint.getvalue())}; see `{program} --help`") from None


def sentence(box: str) -> str:
    """Returns the message in one of tyro's boxes, without the frame, the colours and the hints."""
    plain = re.sub(r"\x1b\[[0-9;]*m", "", box)
    stripped = [raw.strip("│| \t") for raw in plain.splitlines()]
    if len(stripped) > 1 and re.fullmatch(r"-{3,}", stripped[1]):
        del stripped[:2]  # the title, where the terminal has letters of ASCII only
    lines: list[str] = []
    for line in stripped:
        if re.fullmatch(r"[─-]{3,}", line):
            break
        if line and not re.match(r"[╭╰┌└+]", line):
            lines.append(line)
    text = " ".join(lines).removesuffix("(required)").rstrip()
    text = re.sub(r"(?<=[^\s.])\.$", "", text)  # the sentence's, not an argument such as `..`
    text = text.removeprefix("Error parsing ").replace(": must be", " must be", 1)
    return text[:1].lower() + text[1:] if text else "the arguments are wrong"
