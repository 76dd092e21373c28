"""What an engine is: a way to run a function of one walker for a whole population."""

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable


@runtime_checkable
class Mapped(Protocol):
    """A function of one walker, run for many walkers at once."""

    @property
    def compile_s(self) -> float:
        """Seconds spent tracing and compiling so far."""
        ...

    def prepare(self, *args: Any) -> None:
        """Compiles for arguments of these shapes and types without running; structs serve."""
        ...

    def __call__(self, *args: Any) -> Any:
        """Returns the function's results for every walker, with a leading batch axis."""
        ...


@runtime_checkable
class Engine(Protocol):
    """Maps functions over walkers. A module with these two functions is an engine."""

    def vmap(
        self, function: Callable[..., Any], /, in_axes: Any = 0, *, results: Any = None
    ) -> Mapped:
        """Returns what `jax.jit(jax.vmap(function, in_axes))` means, compiled when it is needed.

        Args:
          function: works on one walker.
          in_axes: 0 or None for each argument, or for each part of one, as for `jax.vmap`.
          results: a tree like what `function` returns; an engine that can tell a kernel by the
            settings of `function` needs it, and others ignore it.
        """
        ...

    def devices(self) -> str:
        """Returns in words what it runs on."""
        ...
