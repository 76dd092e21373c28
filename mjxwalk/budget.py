"""How much memory a process may take, so that what asks for more is refused before it is taken.

Where memory runs out the system or XLA ends the process, at some time, without a word.
"""

import math
import os
import sys
from pathlib import Path
from typing import Any, Literal

from mjxwalk.errors import RunError

# Of control groups, in which containers and jobs run, by their versions 2 and 1.
GROUP_LIMITS = ("memory.max", "memory/memory.limit_in_bytes")
MOST_TRIALS = 1_000_000  # of one walker; ours: days
TABLE_COPIES = 3  # of grounds at a time; ours: what is drawn, what is summed, and the result


def machine() -> int:
    """Returns how many bytes of memory this machine has; all one can count on Windows."""
    if not hasattr(os, "sysconf"):  # Windows: too little memory ends a process without a word
        return sys.maxsize
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def limit(kind: Literal["RLIMIT_AS", "RLIMIT_DATA"]) -> int:
    """Returns a limit of this process, bytes; all one can count where there is none."""
    try:
        import resource
    except ImportError:  # Windows has no such limits
        return sys.maxsize
    soft, _ = resource.getrlimit(getattr(resource, kind))
    return sys.maxsize if soft == resource.RLIM_INFINITY else soft


def available() -> int:
    """Returns how many bytes this process may take: the machine's, or fewer where it has a limit.

    Others may have taken some of them.
    """
    limits = [machine(), limit("RLIMIT_AS"), limit("RLIMIT_DATA")]
    for name in GROUP_LIMITS:
        try:
            limits.append(int(Path("/sys/fs/cgroup", name).read_text(encoding="utf-8")))
        except (OSError, ValueError):  # no such group, or the word "max"
            continue
    return min(limits)


def check(needed: int | float, what: str, instead: str) -> None:
    """Raises RunError unless so many bytes fit into the memory that this process may take.

    Args:
      needed: bytes.
      what: takes them, with its verb.
      instead: what to do, as an imperative.
    """
    if needed > available():
        raise RunError(
            f"{what} {needed / 1e9:.3g} GB, and this process may have {available() / 1e9:.3g} GB "
            f"of memory; {instead}"
        )


def check_asked(flag: str, trials: int) -> None:
    """Raises RunError unless a walker can be tried as often as an argument asks for."""
    if trials > MOST_TRIALS:
        raise RunError(f"{flag} must be at most {MOST_TRIALS:,}, got {trials:,}")


def check_grounds(env: object, num: int) -> None:
    """Raises RunError unless so many grounds fit into memory.

    Args:
      env: with a `terrain` that tells its `num_nodes`, and perhaps a `course`.
      num: of grounds.
    """
    nodes = getattr(getattr(env, "terrain", None), "num_nodes", 1)
    each = math.prod(nodes) if isinstance(nodes, tuple) else nodes
    course: Any = getattr(env, "course", None)
    if course is not None:
        each += course.num_nodes * course.num_channels
    floats = num * each
    check(
        4.0 * TABLE_COPIES * floats,
        f"{num:,} terrains take",
        "ask for fewer terrains or trials, or for shorter ones (env.terrain.length or "
        "env.course.length)",
    )
