"""Which engine runs, and why; and what has to be set before JAX starts."""

import contextlib
import os
from typing import NamedTuple

import jax

from mjxwalk import cache_folder, forking, terminal
from mjxwalk.engines import registry
from mjxwalk.engines.protocol import Engine


class Choice(NamedTuple):
    """An engine's name and the reason for it, in words."""

    name: str
    why: str

    @property
    def engine(self) -> Engine:
        """The engine itself, whose module is imported here."""
        return registry.load(self.name)


def prepare() -> None:
    """Readies JAX for the engines; without effect once JAX has devices.

    Every CPU core becomes a device of its own, since XLA runs a batch of small operations on one
    core only, and what XLA has compiled is kept on disk.

    Raises:
      ForkedError: JAX cannot compute in this process.
    """
    forking.check()
    with contextlib.suppress(RuntimeError):
        jax.config.update("jax_num_cpu_devices", num_cores())
    if jax.config.values["jax_compilation_cache_dir"] is None:
        folder = cache_folder.folder("xla")
        # XLA takes no name that is not UTF-8.
        if folder is not None and not terminal.has_other_bytes(str(folder)):
            jax.config.update("jax_compilation_cache_dir", str(folder))


def num_cores() -> int:
    """Returns the number of CPU cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def choose(name: str) -> Choice:
    """Returns the engine that a name stands for.

    On an accelerator `auto` is mjx. `lanes-xla` may be faster, but nobody has measured it on one
    yet; `mjxwalk bench` does where there is one.

    Raises:
      ValueError: there is no such engine.
    """
    registry.check(name)
    if name != registry.AUTO:
        return Choice(name, "asked for")
    if jax.default_backend() == "cpu":
        return Choice("lanes", "JAX sees no accelerator, and on a CPU lanes is the fastest")
    return Choice("mjx", f"JAX sees an accelerator ({jax.devices()[0].device_kind})")
