"""Arguments to a command; what tyro has to complain of, in one sentence."""

import contextlib
import io
import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, TypeAlias, TypeVar

import tyro

from mjxwalk.cli.commands import Command
from mjxwalk.errors import RunError

CommandT = TypeVar("CommandT", bound=Command)


def parse(program: str, command: type[CommandT], args: Sequence[str]) -> CommandT:
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


def _primitive(metavar: str, read: Callable[[str], Any], words: str, none: str) -> Any:
    """Returns how a value of one word is read, shown, and complained of.

    Args:
      metavar: stands for it in the help.
      read: from the word; ValueError if it cannot be.
      words: what it must be.
      none: how None is shown.
    """

    def from_words(args: list[str]) -> Any:
        try:
            return read(args[0])
        except ValueError:
            raise ValueError(f"must be {words}, got {args[0]!r}") from None

    def is_value(value: Any) -> bool:
        return value is None or isinstance(value, int | float | str | Path)

    def to_words(value: Any) -> list[str]:
        return [none if value is None else str(value)]

    return tyro.constructors.PrimitiveConstructorSpec[Any](
        nargs=1,
        metavar=metavar,
        instance_from_str=from_words,
        is_instance=is_value,
        str_from_instance=to_words,
    )


def _finite(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(text)
    return number


def _count_or_all(text: str) -> int | None:
    return None if text == "all" else int(text)


def _seed(text: str) -> int:
    number = int(text)
    if not 0 <= number < SEEDS:  # beyond them JAX begins again from 0 without a word
        raise ValueError(text)
    return number


EXPERIMENT = "per-experiment"
SEEDS = 2**32  # that JAX's keys tell apart
Seed: TypeAlias = Annotated[
    int, _primitive("INT", _seed, f"a whole number from 0 to {SEEDS - 1}", none="")
]
RunFolder: TypeAlias = tyro.conf.Positional[Annotated[Path, tyro.conf.arg(metavar="RUN")]]
OptionalInt: TypeAlias = Annotated[
    int | None, _primitive("INT", int, "a whole number", none=EXPERIMENT)
]
OptionalFloat: TypeAlias = Annotated[
    float | None, _primitive("FLOAT", _finite, "a number", none=EXPERIMENT)
]
OptionalName: TypeAlias = Annotated[str | None, _primitive("NAME", str, "a name", none=EXPERIMENT)]
CountOrAll: TypeAlias = Annotated[
    int | None, _primitive("INT|all", _count_or_all, "a whole number or all", none="all")
]
SweepPath: TypeAlias = Annotated[
    Path | None,
    _primitive("PATH", Path, "a folder", none="runs/sweep-EXPERIMENT-GRID"),
]
NameOrCluster: TypeAlias = Annotated[
    str | None, _primitive("HOST:PORT", str, "a host and a port", none="cluster's")
]
NumberOrCluster: TypeAlias = Annotated[
    int | None, _primitive("INT", int, "a whole number", none="cluster's")
]
CoresOrShare: TypeAlias = Annotated[
    int | None, _primitive("INT", int, "a whole number", none="shared-out")
]
GigabytesOrAll: TypeAlias = Annotated[
    float | None, _primitive("FLOAT", _finite, "a number", none="no-limit")
]
NameOrDefault: TypeAlias = Annotated[
    str | None, _primitive("NAME", str, "a name", none="the-default")
]
OutPath: TypeAlias = Annotated[
    Path | None,
    _primitive("PATH", Path, "a folder", none="runs/EXPERIMENT-SEED-TIME"),
]
