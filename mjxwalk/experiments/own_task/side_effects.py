"""Finds what functions of a walker change outside of themselves: it happens once, when traced."""

import ast
import types
from collections.abc import Iterator
from typing import Any

import jax
from jax.core import Tracer

from mjxwalk.errors import RunError
from mjxwalk.experiments.own_task.execution import Task
from mjxwalk.experiments.own_task.naming import check_syntax

CONTAINERS = (list, dict, set)
MOST = 1000  # parts of a container that are looked at; ours
INSTEAD = (
    "which is a side effect: it happens once, when the function is traced, and not in each step; "
    "put what changes into the state"
)


def snapshot(module: types.ModuleType) -> dict[str, object]:
    """Returns what tells whether a global of a module was changed, by name."""
    return {name: _mark(value) for name, value in _globals(module)}


def check_unchanged(task: Task, before: dict[str, object]) -> None:
    """Raises RunError if a global of a task is another than before its functions were traced."""
    after = snapshot(task.module)
    for name in after:
        if before.get(name) != after[name]:
            line = _line(task, name)
            raise RunError(f"{task.text.shown}{line}: a traced function changes {name}, {INSTEAD}")


def check_leaks(task: Task) -> None:
    """Raises RunError if a global of a task has a stand-in for numbers of a traced function."""
    for name, value in _globals(task.module):
        if any(isinstance(part, Tracer) for part in _parts(value)):
            line = _line(task, name)
            raise RunError(
                f"{task.text.shown}{line}: a traced function keeps a value in {name}, {INSTEAD}"
            )


def _globals(module: types.ModuleType) -> Iterator[tuple[str, Any]]:
    for name, value in list(vars(module).items()):
        is_code = isinstance(value, type | types.ModuleType | types.FunctionType)
        if not name.startswith("__") and not is_code:
            yield name, value


def _mark(value: Any) -> object:
    if isinstance(value, CONTAINERS):
        parts = [id(part) for part in list(_parts(value))]
        return type(value), len(value), tuple(parts)
    if isinstance(value, bool | int | float | str | bytes):
        return value if value == value else "nan"
    return id(value)


def _parts(value: Any) -> Iterator[Any]:
    yield from [value] if not isinstance(value, CONTAINERS) else []
    if isinstance(value, CONTAINERS):
        inner = value.values() if isinstance(value, dict) else value
        for _, part in zip(range(MOST), list(inner), strict=False):
            yield from jax.tree.leaves(part)
    elif hasattr(value, "__dict__"):
        for part in list(vars(value).values())[:MOST]:
            yield from jax.tree.leaves(part) if not isinstance(part, types.ModuleType) else ()


def _line(task: Task, name: str) -> str:
    """Returns the line on which a function changes a global, as a text behind the file's name."""
    tree = check_syntax(task.text)
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    found = [
        (not isinstance(node.ctx, ast.Store), node.lineno)
        for function in functions
        for node in ast.walk(function)
        if isinstance(node, ast.Name) and node.id == name
    ]
    return f":{min(found)[1]}" if found else ""
