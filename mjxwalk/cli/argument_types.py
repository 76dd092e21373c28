"""Types of arguments that several commands share: how a word is read, shown, and refused."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import tyro


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


def _contact_law(text: str) -> str:
    if text not in LAWS:
        raise ValueError(text)
    return text


LAWS = ("points", "mujoco")
TERRAINS = 20  # of verify
TRIALS = 100  # of verify, in Gymnasium's tasks
EXPERIMENT = "per-experiment"
SEEDS = 2**32  # that JAX's keys tell apart
Seed: TypeAlias = Annotated[
    int, _primitive("INT", _seed, f"a whole number from 0 to {SEEDS - 1}", none="")
]
Source: TypeAlias = tyro.conf.Positional[Annotated[str, tyro.conf.arg(metavar="RUN|zoo:NAME")]]
OptionalFile: TypeAlias = Annotated[Path | None, tyro.conf.arg(metavar="FILE")]
EngineName: TypeAlias = Literal["auto", "mjx", "lanes", "lanes-xla"]
RunFolder: TypeAlias = tyro.conf.Positional[Annotated[Path, tyro.conf.arg(metavar="RUN")]]
OptionalInt: TypeAlias = Annotated[
    int | None, _primitive("INT", int, "a whole number", none=EXPERIMENT)
]
OptionalFloat: TypeAlias = Annotated[
    float | None, _primitive("FLOAT", _finite, "a number", none=EXPERIMENT)
]
OptionalName: TypeAlias = Annotated[str | None, _primitive("NAME", str, "a name", none=EXPERIMENT)]
ContactLaw: TypeAlias = Annotated[
    str | None,
    _primitive("|".join(LAWS), _contact_law, " or ".join(LAWS), none=LAWS[0]),
]
OtherContactLaw: TypeAlias = Annotated[
    str | None,
    _primitive("|".join(LAWS), _contact_law, " or ".join(LAWS), none="as-evolved"),
]
TerrainCount: TypeAlias = Annotated[
    int | None, _primitive("INT", int, "a whole number", none=str(TERRAINS))
]
TrialCount: TypeAlias = Annotated[
    int | None, _primitive("INT", int, "a whole number", none=str(TRIALS))
]
DigestOrAny: TypeAlias = Annotated[str | None, _primitive("HEX", str, "a digest", none="any")]
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
