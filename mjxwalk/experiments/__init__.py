"""What evolves: experiments and studies by name, and what a run's settings make of them."""

from mjxwalk.experiments.registry import (
    ANY_BODY,
    CONTROLLERS,
    DEFAULT,
    get,
    get_study,
    names,
    phases,
    register,
    studies,
)
from mjxwalk.experiments.stored import from_data, of_run

__all__ = [
    "ANY_BODY",
    "CONTROLLERS",
    "DEFAULT",
    "from_data",
    "get",
    "get_study",
    "names",
    "of_run",
    "phases",
    "register",
    "studies",
]
