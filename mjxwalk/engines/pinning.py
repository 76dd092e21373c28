"""Settings of JAX that results depend on: the same wherever, and by whomever, they are made."""

import contextlib
import os
from collections.abc import Callable, Generator, Mapping
from typing import Any

import jax

from mjxwalk import installing
from mjxwalk.errors import RunError

Manager = Callable[[Any], contextlib.AbstractContextManager[Any]]

# Each as it is by default, and what sets it for a while in one thread.
PINNED: Mapping[str, tuple[Any, Manager]] = {
    "jax_enable_x64": (False, jax.enable_x64),
    "jax_threefry_partitionable": (True, jax.threefry_partitionable),
    "jax_default_prng_impl": ("threefry2x32", jax.default_prng_impl),
    "jax_default_matmul_precision": (None, jax.default_matmul_precision),
    "jax_numpy_dtype_promotion": ("standard", jax.numpy_dtype_promotion),
    "jax_numpy_rank_promotion": ("allow", jax.numpy_rank_promotion),
    "jax_enable_custom_prng": (False, jax.enable_custom_prng),
    "jax_legacy_prng_key": ("allow", jax.legacy_prng_key),
    "jax_debug_nans": (False, jax.debug_nans),
    "jax_debug_infs": (False, jax.debug_infs),
    "jax_debug_key_reuse": (False, jax.debug_key_reuse),
    "jax_disable_jit": (False, jax.disable_jit),
    "jax_check_tracer_leaks": (False, jax.check_tracer_leaks),
    "jax_enable_checks": (False, jax.enable_checks),
    "jax_no_tracing": (False, jax.no_tracing),
    "jax_no_execution": (False, jax.no_execution),
    "jax_thread_guard": (False, jax.thread_guard),
}
# Each as it is by default; JAX has nothing that sets it for a while.
REQUIRED: Mapping[str, Any] = {
    "jax_random_seed_offset": 0,
    "jax_high_dynamic_range_gumbel": False,
    "jax_disable_most_optimizations": False,
    "jax_exec_time_optimization_effort": 0.0,
    "jax_optimization_level": "UNKNOWN",
    "eager_constant_folding": False,
}


@contextlib.contextmanager
def pinned() -> Generator[None]:
    """Sets what results depend on as JAX has it by default, in this thread, until the block ends.

    Also a decorator. Where nothing has been changed, it changes nothing.

    Raises:
      RunError: a setting is another that cannot be set for a while.
    """
    found = settings()
    for name, value in REQUIRED.items():
        if found[name] != value:
            raise RunError(
                f"{name} is {found[name]}, and results depend on it; set it to {value}, or unset "
                f"{name.upper()} in the environment"
            )
    with contextlib.ExitStack() as stack:
        for name, (value, manager) in PINNED.items():
            if found[name] != value:
                stack.enter_context(manager(value))
        yield


def settings() -> dict[str, Any]:
    """Returns, as plain values, the settings that results depend on as they are in this thread."""
    found = jax.config.values
    chosen = {name: found[name] for name in (*PINNED, *REQUIRED) if name in found}
    plain = {name: getattr(value, "value", value) for name, value in chosen.items()}
    return plain | {"XLA_FLAGS": os.environ.get("XLA_FLAGS")}


def why_not_started(error: Exception) -> str | None:
    """Returns why JAX has no devices, in a sentence; None where it has.

    Args:
      error: the first that was seen; JAX tells the cause only once.
    """
    try:
        jax.devices()
        return None
    except Exception:  # backends and their plugins fail in as many ways as there are
        lines = str(error).strip().splitlines()
    reason = f": {lines[0].rstrip('.')}" if lines else f" ({type(error).__name__})"
    for name in ("jax_platforms", "jax_platform_name"):
        asked = jax.config.values[name]
        if asked:
            cuda = f", or add CUDA with: {installing.of_extra('cuda')}" if "cuda" in asked else ""
            return (
                f"JAX does not start on {asked!r}, which {name.upper()} asks for{reason}; unset "
                f"it, or set it to cpu{cuda}"
            )
    return f"JAX does not start{reason}"
