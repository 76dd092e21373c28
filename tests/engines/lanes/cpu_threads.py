"""The kernel that is meant for a GPU's threads, on the CPU: one walker after another."""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import jax
import numpy as np

from mjxwalk.engines import lanes_ptx
from mjxwalk.engines.lanes.backend import machine_code
from mjxwalk.engines.lanes.backend.kernel import ENTRY
from mjxwalk.engines.lanes.backend.thread_kernel import Frame, emit_thread_kernel
from mjxwalk.engines.lanes.runtime import batches, thread_pool


def load(lowered: lanes_ptx.Lowered) -> machine_code.Loaded:
    """Returns the kernel for the CPU, to be called as those of `lanes` are."""
    target = dataclasses.replace(machine_code.host(), width=1, estimates=False)
    arguments, results = lowered.arguments, lowered.results
    frame = _frame(len(arguments), len(results))
    text = emit_thread_kernel(lowered.program, arguments, results, target, frame)
    return machine_code.Loaded(machine_code.assemble(text, target))


def run(
    loaded: machine_code.Loaded, inputs: Sequence[Any], outputs: Sequence[Any], count: int
) -> None:
    """Runs the kernel for all walkers; the outputs are written."""
    thread_pool.run(loaded, 0, inputs, outputs, count, 1)


def vmap(function: Callable[..., Any], in_axes: Any = 0) -> Callable[..., Any]:
    """Returns what `jax.vmap(function, in_axes)` is, by that kernel."""

    def mapped(*args: Any) -> Any:
        lowered = lanes_ptx.lower(function, in_axes, *args)
        leaves, axes = jax.tree.leaves(args), batches.axes_of_leaves(in_axes, args, {})
        inputs = [batches.contiguous(*pair) for pair in zip(leaves, axes, strict=True)]
        count = batches.num_walkers(leaves, axes)
        outputs = [np.empty((count, *r.shape), r.dtype) for r in lowered.results]
        run(load(lowered), inputs, outputs, count)
        return jax.tree.unflatten(lowered.tree, outputs)

    return mapped


def _frame(num_inputs: int, num_outputs: int) -> Frame:
    """Returns a loop over walkers around a walker's code."""
    start: list[str] = []
    for kind, count in (("input", num_inputs), ("output", num_outputs)):
        for number in range(count):
            start.append(f"  %{kind}.{number}.at = getelementptr ptr, ptr %{kind}s, i64 {number}")
            start.append(f"  %{kind}.{number} = load ptr, ptr %{kind}.{number}.at")
    start += [
        "  br label %walk",
        "walk:",
        "  %walker = phi i64 [0, %entry], [%walker.next, %end]",
    ]
    tail = [
        "end:",
        "  %walker.next = add i64 %walker, 1",
        "  %more = icmp ult i64 %walker.next, %count",
        "  br i1 %more, label %walk, label %leave",
        "leave:",
        "  ret void",
        "}",
    ]
    return Frame(pointer="ptr", space="", head=[ENTRY + " {", "entry:"], start=start, tail=tail)
