"""What a terminal shows, and obeys in nothing: names in files come from anybody."""

import contextlib
import re
import sys
from collections.abc import Generator, Iterable
from typing import IO, TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from rich.console import Console

# Control characters but for tab and new line, what turns the direction of writing around, and
# halves of characters, which stand for bytes that are no text.
OBEYED = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)


def visible(text: str) -> str:
    """Returns a text with escapes in the place of what a terminal would obey, or cannot show."""
    return OBEYED.sub(lambda found: ascii(found.group())[1:-1], text)


def has_other_bytes(text: str) -> bool:
    """Returns whether a text has bytes in it that are no UTF-8, as names of files may."""
    return any("\ud800" <= letter <= "\udfff" for letter in text)


def one_line(text: str) -> str:
    """Returns a text that is visible in one line, such as a name in a table."""
    return visible(text).replace("\n", "\\n").replace("\t", "\\t")


class _Visible:
    """A stream that writes what is visible of a text; it is as the stream that it writes to."""

    def __init__(self, stream: Any) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        self.stream.write(visible(text))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


def say(text: str) -> None:
    """Prints a line at once, also where what is printed goes to a file."""
    print(text, flush=True)


@contextlib.contextmanager
def showing() -> Generator[None]:
    """Has all that is printed in the block be visible."""
    with contextlib.ExitStack() as stack:
        if sys.stdout is not None:
            stack.enter_context(contextlib.redirect_stdout(cast("IO[str]", _Visible(sys.stdout))))
        if sys.stderr is not None:
            stack.enter_context(contextlib.redirect_stderr(cast("IO[str]", _Visible(sys.stderr))))
        yield


def console() -> "Console":
    """Returns a console of rich for what is printed; it alone may send what a terminal obeys.

    Texts from files go through `visible` before it gets them.
    """
    from rich.console import Console

    stream = sys.stdout
    return Console(highlight=False, file=getattr(stream, "stream", stream))
