"""Tests of the table of where operations come from."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from mjxwalk.engines.lanes import by_source, explain, vmap
from mjxwalk.engines.lanes.by_source import Frames

ONE = np.float32(1.0)
THREE = np.ones(3, np.float32)


def own(counts: Any, unit: by_source.Unit = "function") -> dict[str, int]:
    """Returns operations by the last word of a row's name."""
    return {row.name.split()[-1]: row.own for row in by_source.rows(counts, unit) if row.own}


def product(x: Any, y: Any) -> Any:
    return x * y


def squares(x: Any) -> Any:
    return jnp.sum(x * x)


def test_each_operation_stands_at_the_function_that_asked_for_it() -> None:
    def function(x: Any, y: Any) -> Any:
        return product(x, y) + squares(x)

    counts = by_source.sources(function, THREE, THREE).of_step
    # An input is an operation of the first line that reads it.
    assert own(counts) == {"product": 3 + 6, "squares": 3 + 2, function.__qualname__: 3}
    whole = {row.name.split()[-1]: row.whole for row in by_source.rows(counts, "function")}
    assert whole == {"product": 9, "squares": 5, function.__qualname__: 17}


def test_all_operations_of_a_kernel_are_told_and_no_other() -> None:
    kernel = vmap(explain.swing)
    kernel.prepare(THREE, THREE)
    assert kernel.compiled is not None
    found = by_source.sources(explain.swing, ONE, ONE)
    assert sum(found.of_step.values()) == kernel.compiled.operations
    lines = own(found.of_step, "function")
    assert list(lines) == ["swing.<locals>.step", "swing.<locals>.<lambda>"]


def test_a_loop_inside_a_step_counts_as_often_as_it_turns() -> None:
    def function(x: Any) -> Any:
        def step(state: Any) -> Any:
            inner = jax.lax.fori_loop(0, 7, lambda _, y: product(y, y), state[1])
            return state[0] + 1.0, inner

        return jax.lax.while_loop(lambda state: state[0] < 5.0, step, (0.0, x))[1]

    assert own(by_source.sources(function, ONE).of_step)["product"] == 7


def test_a_function_that_jax_remembers_counts_where_it_is_called() -> None:
    def first(x: Any) -> Any:
        return jnp.cross(x, x + 1.0)

    def second(x: Any) -> Any:
        return jnp.cross(x, x + 2.0)

    counts = by_source.sources(lambda x: first(x) + second(x), THREE).of_step
    found = own(counts)
    names = [name for name in found if "first" in name or "second" in name]
    assert len(names) == 2
    assert found[names[0]] - found[names[1]] == 3  # the inputs, which the first one reads


def test_a_table_has_the_largest_rows_and_the_sum_of_all() -> None:
    here: Frames = (by_source.Frame("/some/where/a.py", "f", 3),)
    there: Frames = (by_source.Frame("/some/where/b.py", "g", 5), *here)
    told = by_source.text({here: 10, there: 2_000}, "line", 1).splitlines()
    assert told[1].split() == ["2,000", "2,000", "some/where/b.py:5"]
    assert told[-1].split() == ["2,010", "in", "all"]
    assert len(told) == 3
