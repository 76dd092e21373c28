"""Executes a user's file and finds the experiment that it makes; imports JAX."""

import ast
import dataclasses
import linecache
import os
import re
import sys
import types
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mjxwalk.errors import RunError, near
from mjxwalk.experiments.own_task import blame, naming, trust
from mjxwalk.runs import task_file
from mjxwalk.runs.config import Code
from mjxwalk.runs.task_file import TaskText

# Names of modules; none begins as those of this package do, whose classes are known by their files.
MODULE = "own_task_"
# What every kind of experiment has, and the command line needs.
EVOLVABLE = (
    "name",
    "generations",
    "population_size",
    "terrains_per_evaluation",
    "goal",
    "weight",
    "start",
    "template",
    "make_strategy",
    "sample_trials",
    "rollout",
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Task:
    """A user's file that was executed.

    Attributes:
      experiment: that it makes.
      code: for the settings of its runs.
      text: that was executed.
      module: what it became.
      beside: files of its own folder that it imported, which runs do not keep.
    """

    experiment: Any
    code: Code
    text: TaskText
    module: types.ModuleType
    beside: tuple[str, ...] = ()

    def named(self, name: str) -> Any:
        """Returns the experiment, with another controller if NAME+CONTROLLER says so.

        Raises:
          ValueError: it takes no such controller.
        """
        own, _, controller = name.partition("+")
        if not controller or own != self.experiment.name:
            return self.experiment
        from mjxwalk.experiments import other_controllers

        return other_controllers.with_controller(self.experiment, controller)

    def place(self, keyword: str = "") -> str:
        """Returns file and line where the experiment, or one argument of it, is written."""
        for node in naming.check_syntax(self.text).body:
            names = {each.id for each in ast.walk(node) if isinstance(each, ast.Name)}
            if isinstance(node, ast.Assign | ast.AnnAssign) and self.code.name in names:
                given = [each for each in ast.walk(node) if isinstance(each, ast.keyword)]
                lines = [each.value.lineno for each in given if each.arg == keyword]
                return f"{self.text.shown}:{(lines or [node.lineno])[0]}"
        return self.text.shown


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Executed:
    """A text that was executed in this process, and the strategies that it registered."""

    module: types.ModuleType
    tree: ast.Module
    strategies: Mapping[str, Any]
    beside: tuple[str, ...]


# By digest: where a text is read a second time, its classes are the same.
_cache: dict[str, _Executed] = {}


def of_user(asked: str) -> Task:
    """Returns the task that a user named, executed; its folder is importable from now on.

    Args:
      asked: as `naming.find` takes it.

    Raises:
      RunError: there is no such file, an error is in it, or it makes no one experiment.
    """
    named, path = naming.find(asked)
    text = naming.read(path)
    folder = str(path.resolve().parent)
    if folder not in sys.path:
        sys.path.append(folder)  # ours: last, so that no file beside it takes a library's place
    executed = _execute(text, is_main=True, folder=folder)
    experiment, name = _choose(executed, text, named.name, named.file)
    code = Code(file=path.name, name=name, sha256=text.sha256)
    return Task(
        experiment=experiment,
        code=code,
        text=text,
        module=executed.module,
        beside=executed.beside,
    )


def of_run(folder: Path, code: Code, *, is_main: bool = False) -> Task:
    """Returns the task of a run, executed if this user trusts it.

    What is executed is the text that was compared with the digest, from one reading of the file.

    Args:
      folder: of the run.
      code: that its settings have.
      is_main: whether it is what this process evolves; the strategies that it registers are then
        those of that name from now on.

    Raises:
      RunError: the text is not trusted, was changed, or has an error in it.
    """
    trust.check(folder, code)
    text = task_file.read(folder, code)
    executed = _execute(text, is_main=is_main)
    experiment, _ = _choose(executed, text, code.name, text.shown)
    return Task(experiment=experiment, code=code, text=text, module=executed.module)


def _execute(text: TaskText, *, is_main: bool, folder: str | None = None) -> _Executed:
    from mjxwalk import strategies

    key = text.sha256
    before = dict(strategies.FACTORIES)
    known = _cache.get(key)
    if known is None:
        known = _run(text, folder)
        registered = {
            name: factory
            for name, factory in strategies.FACTORIES.items()
            if before.get(name) is not factory
        }
        known = _cache[key] = dataclasses.replace(known, strategies=registered)
    for name, factory in known.strategies.items():
        # Of two tasks that register a name, the one that evolves here has it.
        strategies.register(name, factory if is_main or name not in before else before[name])
    return known


def _run(text: TaskText, folder: str | None) -> _Executed:
    tree = naming.check_syntax(text)
    blame.executed(text.shown)
    name = f"{MODULE}{text.sha256[:16]}_{len(_cache)}"
    module = types.ModuleType(name)
    module.__file__ = text.shown
    lines = text.content.decode(errors="replace").splitlines(keepends=True)
    linecache.cache[text.shown] = (len(text.content), None, lines, text.shown)
    before = set(sys.modules)
    sys.modules[name] = module  # where dataclasses look for what annotations name
    try:
        exec(compile(tree, text.shown, "exec"), module.__dict__)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        told = blame.located(error) or f"{text.shown}: {blame.message(error)}"
        raise RunError(told + _hint(error, text)) from None
    imported = set(sys.modules) - before - {name}
    beside = tuple(_beside(imported, folder)) if folder else ()
    return _Executed(module=module, tree=tree, strategies={}, beside=beside)


def _hint(error: BaseException, text: TaskText) -> str:
    if isinstance(error, ModuleNotFoundError) and Path(text.shown).name == task_file.FILE:
        return (
            "; a run keeps the one file alone, so a module that was beside it has to be found by "
            "PYTHONPATH"
        )
    return ""


def _beside(names: set[str], folder: str) -> Iterator[str]:
    """Yields the files among modules that lie in a folder, and are not installed there."""
    for name in sorted(names):
        file = getattr(sys.modules.get(name), "__file__", None)
        if isinstance(file, str) and os.path.realpath(file).startswith(folder + os.sep):
            inside = os.path.relpath(os.path.realpath(file), folder)
            if "site-packages" not in inside:
                yield inside


def _choose(executed: _Executed, text: TaskText, name: str, file: str) -> tuple[Any, str]:
    """Returns the experiment of that name, or the only one, and what it is called."""
    made = _experiments(executed)
    if not name and len(made) == 1:
        name = next(iter(made))
    if not name and made:
        raise RunError(
            f"{text.shown} makes {len(made)} experiments, {', '.join(made)}; name one of them: "
            f"mjxwalk evolve {file}:{next(iter(made))}"
        )
    if not name:
        raise RunError(
            f"{text.shown} makes no Experiment; write NAME = Experiment(name=..., env=..., "
            "controller=..., strategy=..., ...) at its top level, as the example does that "
            "`mjxwalk new task FILE` writes"
        )
    found = getattr(executed.module, name, None)
    if found is None:
        raise RunError(f"{text.shown} makes no {name}{near(name, made)}")
    _check(found, text, name)
    return found, name


def _experiments(executed: _Executed) -> dict[str, Any]:
    """Returns the experiments that a module makes, by name; those that it imports are not its."""
    imported = {
        alias.asname or alias.name
        for node in ast.walk(executed.tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    found: dict[str, Any] = {}
    for name, value in vars(executed.module).items():
        is_new = not any(value is other for other in found.values())
        if name not in imported and not name.startswith("__") and is_new and _is_evolvable(value):
            found[name] = value
    return found


def _is_evolvable(value: Any) -> bool:
    is_object = dataclasses.is_dataclass(value) and not isinstance(value, type)
    return is_object and all(hasattr(value, name) for name in EVOLVABLE)


def _check(found: Any, text: TaskText, name: str) -> None:
    """Raises RunError unless an object is an experiment whose runs can be told by its name."""
    if not _is_evolvable(found):
        kind = found.__name__ if isinstance(found, type) else type(found).__name__
        lacks = [each for each in EVOLVABLE if not hasattr(found, each)]
        # One that has most is meant to be an experiment of another kind.
        more = f", which has no {', '.join(lacks)}" if 2 * len(lacks) < len(EVOLVABLE) else ""
        raise RunError(f"{text.shown}: {name} must be an Experiment, got {kind}{more}")
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}", str(found.name)):
        raise RunError(
            f"{text.shown}: the name of {name} must be letters, digits, dots and hyphens, got "
            f"{found.name!r}"
        )
