"""Says in one sentence which line of a user's file an error is of."""

import traceback
import types
from collections.abc import Iterator
from typing import Any

from mjxwalk.errors import first_line

LONGEST = 300  # letters of another's message
NOT_YET = (
    "a value that is not known yet: functions of a walker are traced once, with stand-ins for "
    "their numbers"
)
# What JAX says of values in traced functions, for people who do not know its words.
TRACED = {
    "TracerBoolConversionError": (
        f"`if`, `while`, `and`, `or` or bool() asks for {NOT_YET}; use jnp.where or jax.lax.cond, "
        "and & or | in place of `and` or `or`"
    ),
    "TracerIntegerConversionError": (
        f"an index of a list, range() or int() asks for {NOT_YET}; use a jax.numpy array"
    ),
    "TracerArrayConversionError": (
        f"NumPy, or another library, asks for {NOT_YET}; use jax.numpy in its place"
    ),
    "ConcretizationTypeError": (
        f"float(), int(), range() or a shape asks for {NOT_YET}; use jax.numpy's functions, and "
        "sizes that are settings"
    ),
    "NonConcreteBooleanIndexError": (
        f"the size of a choice by a mask is {NOT_YET}; use jnp.where with three arguments"
    ),
    "UnexpectedTracerError": (
        "it uses a value that a traced function kept outside of itself, which is a side effect; "
        "put the value into the state that the function returns"
    ),
    "FrozenInstanceError": (
        "a setting cannot be changed while walkers move; put what changes into the state"
    ),
}

# The texts that were executed in this process, by the names that Python has for their files.
_executed: set[str] = set()


def executed(file: str) -> None:
    """Takes down that a text with this name was executed."""
    _executed.add(file)


def located(error: BaseException) -> str | None:
    """Returns what to tell of an error in a user's file, with file and line; None of any other."""
    for each in _chain(error):
        frames = traceback.walk_tb(each.__traceback__)
        lines = [(frame.f_code.co_filename, line) for frame, line in frames]
        ours = [place for place in lines if place[0] in _executed]
        if ours:
            file, line = ours[-1]
            return f"{file}:{line}: {message(each)}"
    return None


def message(error: BaseException) -> str:
    """Returns what an error says, in a line, without what only Python's programmers look for."""
    name = type(error).__name__
    if name in TRACED:
        return TRACED[name]
    if isinstance(error, SystemExit):
        return "sys.exit ends the file before it has made an experiment"
    if isinstance(error, ValueError) and str(error):
        return _short(first_line(error) if "\n" in str(error) else str(error))
    told = traceback.TracebackException.from_exception(error)  # it has "Did you mean"
    return _short(next(iter("".join(told.format_exception_only()).strip().splitlines()), name))


def place_of(thing: Any, function: str) -> str | None:
    """Returns file and line of a function of an object, None if no user's file has it."""
    found: Any = getattr(type(thing), function, None)
    while hasattr(found, "__wrapped__"):
        found = found.__wrapped__
    if not isinstance(found, types.FunctionType):
        return None
    code = found.__code__
    return f"{code.co_filename}:{code.co_firstlineno}" if is_executed(code.co_filename) else None


def is_executed(file: str) -> bool:
    """Returns whether a file is a user's task."""
    return file in _executed


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def _chain(error: BaseException) -> Iterator[BaseException]:
    """Yields an error and those that it came of, each once."""
    seen: set[int] = set()
    found: BaseException | None = error
    while found is not None and id(found) not in seen:
        seen.add(id(found))
        yield found
        found = found.__cause__ or found.__context__
