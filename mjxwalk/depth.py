"""How many layers data has, tables and lists in each other: functions that call themselves for
each layer end in a RecursionError."""

from collections.abc import Iterable, Mapping
from typing import cast

MOST = 64  # ours: ten times the layers of any settings


def is_deep(data: object) -> bool:
    """Returns whether data has more layers than anything that we write."""
    layer: list[object] = [data]
    for _ in range(MOST):
        layer = [inner for each in layer for inner in _inside(each)]
        if not layer:
            return False
    return True


def _inside(each: object) -> Iterable[object]:
    if isinstance(each, Mapping):
        return cast("Mapping[object, object]", each).values()
    return cast("list[object]", each) if isinstance(each, list) else ()
