"""Strategies by name, for configurations and command lines."""

import inspect
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from mjxwalk.errors import near
from mjxwalk.strategies.ars import ars
from mjxwalk.strategies.base import Strategy
from mjxwalk.strategies.cma_es import cma_es
from mjxwalk.strategies.deep_ga import deep_ga
from mjxwalk.strategies.hybrid_ga import hybrid_ga
from mjxwalk.strategies.masks import with_mask
from mjxwalk.strategies.openai_es import openai_es
from mjxwalk.strategies.pattern_search import pattern_search
from mjxwalk.strategies.pgpe import pgpe
from mjxwalk.strategies.restarting_cma_es import bipop_cma_es, ipop_cma_es
from mjxwalk.strategies.self_adaptive_ga import self_adaptive_ga
from mjxwalk.strategies.sep_cma_es import sep_cma_es
from mjxwalk.strategies.snes import snes
from mjxwalk.strategies.truncation_ga import truncation_ga
from mjxwalk.strategies.two_point_ga import two_point_ga
from mjxwalk.strategies.xnes import xnes

Factory = Callable[..., Strategy[Any, Any]]

_OWN: Mapping[str, Factory] = {
    "ars": ars,
    "bipop-cma-es": bipop_cma_es,
    "cma-es": cma_es,
    "deep-ga": deep_ga,
    "hybrid-ga": hybrid_ga,
    "ipop-cma-es": ipop_cma_es,
    "openai-es": openai_es,
    "pattern-search": pattern_search,
    "pgpe": pgpe,
    "self-adaptive-ga": self_adaptive_ga,
    "sep-cma-es": sep_cma_es,
    "snes": snes,
    "truncation-ga": truncation_ga,
    "two-point-ga": two_point_ga,
    "xnes": xnes,
}
_BY_KEYWORD = {inspect.Parameter.KEYWORD_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD}

_factories = dict(_OWN)
FACTORIES: Mapping[str, Factory] = MappingProxyType(_factories)


def register(name: str, factory: Factory) -> None:
    """Adds a strategy, so that experiments and the command line of this process know its name.

    Registering a name again puts the new factory in place of the old, as when a file is read anew.

    Args:
      name: such as "hill-climber"; none of mjxwalk's own.
      factory: makes the strategy; takes `population_size` and each of its hyper-parameters by
        keyword. It may take `mask`, `groups` and `links`, see `make`.

    Raises:
      ValueError: the name is one of mjxwalk's own, or the factory has another signature.
    """
    if name in _OWN:
        raise ValueError(f"there is a strategy {name!r} already; choose another name")
    signature = inspect.signature(factory)
    kinds = {parameter.kind for parameter in signature.parameters.values()}
    if "population_size" not in signature.parameters or not kinds <= _BY_KEYWORD:
        raise ValueError(
            f"the factory of {name} must take population_size and each hyper-parameter by keyword, "
            f"got {signature}"
        )
    _factories[name] = factory


def make(name: str, *, population_size: int, **options: Any) -> Strategy[Any, Any]:
    """Returns the strategy of a name, as a key of `FACTORIES`.

    What is known of a controller serves every strategy: a `mask` that its factory does not take is
    put around it, see `with_mask`, and `groups` and `links` that it has no use for are left out.

    Args:
      name: strategy, such as "self-adaptive-ga".
      population_size: genotypes in a generation.
      options: the factory's other hyper-parameters, and `mask`, `groups` and `links`.

    Raises:
      ValueError: the name or an option is unknown, or an option is missing or out of its range.
    """
    if name not in FACTORIES:
        raise ValueError(f"unknown strategy {name!r}{near(name, FACTORIES)}")
    factory = FACTORIES[name]
    parameters = inspect.signature(factory).parameters
    known = [option for option in parameters if option != "population_size"]
    mask = None if "mask" in known else options.pop("mask", None)
    for unused in {"groups", "links"} - set(known):
        options.pop(unused, None)
    for option in options:
        if option not in known:
            raise ValueError(f"unknown option {option!r} of {name}{near(option, known)}")
    missing = [
        option
        for option in known
        if parameters[option].default is inspect.Parameter.empty and option not in options
    ]
    if missing:
        raise ValueError(f"{name} needs a value for {' and '.join(missing)}")
    strategy: Any = factory(population_size=population_size, **options)
    if not isinstance(strategy, Strategy):
        raise ValueError(f"the factory of {name} must make a Strategy, got {strategy!r}")
    return strategy if mask is None else with_mask(strategy, mask)


def carry_over(name: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the hyper-parameters of another strategy that one takes too, for a comparison.

    A strategy that starts with its `sigma` gets the other's `initial_sigma` for it.

    Args:
      name: strategy to be made.
      options: hyper-parameters of the other.

    Raises:
      ValueError: the name is unknown.
    """
    if name not in FACTORIES:
        raise ValueError(f"unknown strategy {name!r}{near(name, FACTORIES)}")
    known = inspect.signature(FACTORIES[name]).parameters
    carried = {option: value for option, value in options.items() if option in known}
    if "sigma" in known and "initial_sigma" not in known and "initial_sigma" in options:
        carried["sigma"] = options["initial_sigma"]
    return carried
