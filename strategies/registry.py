"""Strategies by name, for configurations and command lines."""

import difflib
import inspect
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any

from mjxwalk.strategies.base import Strategy
from mjxwalk.strategies.hybrid_ga import hybrid_ga
from mjxwalk.strategies.pattern_search import pattern_search
from mjxwalk.strategies.self_adaptive_ga import self_adaptive_ga
from mjxwalk.strategies.two_point_ga import two_point_ga

FACTORIES: Mapping[str, Callable[..., Strategy[Any, Any]]] = MappingProxyType(
    {
        "hybrid-ga": hybrid_ga,
        "pattern-search": pattern_search,
        "self-adaptive-ga": self_adaptive_ga,
        "two-point-ga": two_point_ga,
    }
)


def make(name: str, *, population_size: int, **options: Any) -> Strategy[Any, Any]:
    """Returns the strategy of a name, as a key of `FACTORIES`.

    Args:
      name: strategy, such as "self-adaptive-ga".
      population_size: genotypes in a generation.
      options: the factory's other hyper-parameters.

    Raises:
      ValueError: the name or an option is unknown, or an option is missing or out of its range.
    """
    if name not in FACTORIES:
        raise ValueError(f"unknown strategy {name!r}; {_suggest(name, FACTORIES)}")
    factory = FACTORIES[name]
    parameters = inspect.signature(factory).parameters
    known = [option for option in parameters if option != "population_size"]
    for option in options:
        if option not in known:
            raise ValueError(f"unknown option {option!r} of {name}; {_suggest(option, known)}")
    missing = [
        option
        for option in known
        if parameters[option].default is inspect.Parameter.empty and option not in options
    ]
    if missing:
        raise ValueError(f"{name} needs a value for {' and '.join(missing)}")
    return factory(population_size=population_size, **options)


def _suggest(wrong: str, known: Iterable[str]) -> str:
    """Returns the names close to a wrong one, or all when none is."""
    names = sorted(known)
    near = difflib.get_close_matches(wrong, names)
    return f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(names)}"
