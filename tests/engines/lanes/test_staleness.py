"""A kernel is the kernel of this function with these values, in this process and in the next."""

import importlib.util
import marshal
import os
import shutil
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

import mjxwalk.envs
import mjxwalk.strategies
from mjxwalk.engines import lanes

X = np.ones(4, np.float32)

# Every function multiplies by V, which reaches it in another way.
MEANINGS = """
import collections, dataclasses, enum, functools, os, sys, types
import jax, jax.numpy as jnp, numpy as np
from mjxwalk.engines import lanes
import mjxwalk.rollout as library

V = float(sys.argv[1])
X = np.ones(4, np.float32)
FUNCTIONS = {}
add = lambda function: FUNCTIONS.setdefault(function.__name__, function)

@add
def reads_a_global(x): return x * V

ARRAY = np.full(4, V, np.float32)
@add
def reads_a_global_array(x): return x * ARRAY[0]

def helper(x): return x * V
@add
def calls_a_function_that_reads_a_global(x): return helper(x)

class Holder: k = V
@add
def reads_a_class_attribute(x): return x * Holder.k

@add
def reads_an_environment_variable(x): return x * float(os.environ["FACTOR"])

@add
def reads_a_file(x): return x * float(open("factor.txt").read())

@add
def imports_in_the_function(x):
    import chosen
    return chosen.times(x)

def closing(k):
    def over_a_number(x): return x * k
    get = [k].__getitem__
    def over_a_bound_builtin(x): return x * get(0)
    item = np.array([k]).item
    def over_a_method_of_an_array(x): return x * item()
    made = collections.defaultdict(lambda: k)
    def over_a_default_factory(x): return x * made["a"]
    thing = types.SimpleNamespace(k=k)
    def over_an_object(x): return x * thing.k
    cell = functools.lru_cache(lambda: k)
    def over_a_cache(x): return x * cell()
    proxy = types.MappingProxyType({"k": k})
    def over_a_mapping(x): return x * proxy["k"]
    iterator = iter([k] * 9)
    def over_an_iterator(x): return x * next(iterator)
    for function in list(locals().values()):
        if isinstance(function, types.FunctionType): add(function)
closing(V)

@dataclasses.dataclass(frozen=True)
class Derived:
    a: float
    def __post_init__(self): object.__setattr__(self, "k", V)
    def derived_attribute(self, x): return x * self.k
    def global_in_a_method(self, x): return x * V
add(Derived(1.0).derived_attribute)
add(Derived(1.0).global_in_a_method)

class Settings(enum.Enum): factor = V
@add
def reads_an_enum(x): return x * Settings.factor.value

@add
def default_argument(x, k=V): return x * k
@add
def keyword_default(x, *, k=V): return x * k

@jax.jit
def jitted(x): return x * V
@add
def calls_a_jitted_function(x): return jitted(x)

library.hook = lambda x: x * V
@add
def patched_library(x): return library.hook(x)

space = {"V": V}
exec("def executed(x): return x * V", space)
add(space["executed"])

class Callable:
    __name__ = "callable_object"
    def __call__(self, x): return x * V
add(Callable())

@functools.partial(jax.tree_util.register_dataclass, data_fields=["x"], meta_fields=["k"])
@dataclasses.dataclass(frozen=True)
class Argument:
    x: object
    k: float
@add
def static_field(a): return a.x * a.k

Pair = collections.namedtuple("Pair", ["a", "b"] if V == 2 else ["b", "a"])
@add
def swapped_names(p): return (p.a * 2 + p.b * 0) * 1.0
ARGUMENTS = {"static_field": Argument(X, V), "swapped_names": Pair(X, X * 1.5)}

@add
def random_configuration(x):
    return x * 0 + V * (1 + 0 * jax.random.uniform(jax.random.key(0)))

for name, function in FUNCTIONS.items():
    print(name, lanes.vmap(function)(ARGUMENTS.get(name, X))[0])
"""


def _run(folder: Path, factor: float) -> dict[str, float]:
    (folder / "factor.txt").write_text(str(factor))
    (folder / "chosen.py").write_text(f"def times(x): return x * {factor}\n")
    os.utime(folder / "chosen.py", (1, 1))  # its time stamp tells nothing
    env = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache"), "FACTOR": str(factor)}
    env |= {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-c", MEANINGS, str(factor)],
        cwd=folder, env=env, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    pairs = (line.rsplit(" ", 1) for line in done.stdout.splitlines())
    return {name: float(value) for name, value in pairs}


def test_next_process_uses_no_kernel_of_other_values(tmp_path: Path) -> None:
    first, second = _run(tmp_path, 2.0), _run(tmp_path, 3.0)
    assert len(first) > 25
    assert first == dict.fromkeys(first, 2.0)
    assert second == dict.fromkeys(first, 3.0)


K = 2.0


@jax.jit
def times_global(x: Any) -> Any:
    """Reads a global in a function that JAX keeps the trace of."""
    return x * K


def step(carry: Any, _: Any) -> Any:
    """Reads a global in the body of a scan, of which JAX keeps the trace too."""
    return carry * K, None


@pytest.mark.parametrize(
    "function",
    [
        lambda x: x * K,
        times_global,
        lambda x: jax.lax.scan(step, x, None, length=1)[0],
        lambda x: jax.lax.cond(x > 0, lambda y: times_global(y), lambda y: y, x),
    ],
)
def test_new_vmap_traces_anew(function: Any, monkeypatch: Any) -> None:
    np.testing.assert_array_equal(lanes.vmap(function)(X), 2 * X)
    monkeypatch.setitem(globals(), "K", 3.0)
    np.testing.assert_array_equal(lanes.vmap(function)(X), 3 * X)


def test_two_local_classes_are_two_functions() -> None:
    def make(k: float) -> Any:
        class Local:
            value = k

        return lambda x: x * Local.value

    np.testing.assert_array_equal(lanes.vmap(make(2.0))(X), 2 * X)
    np.testing.assert_array_equal(lanes.vmap(make(3.0))(X), 3 * X)


@jax.tree_util.register_static
class Static:
    """A static part of an argument, equal to others where it should not be."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Static) and self.value == other.value

    def __hash__(self) -> int:
        return 0

    def __repr__(self) -> str:
        return f"Static({self.value!r})"


@pytest.mark.parametrize("one, other", [(0.0, -0.0), (1, True), (1, 1.0)])
def test_static_parts_that_are_equal_but_not_the_same_are_told_apart(one: Any, other: Any) -> None:
    def function(x: Any, static: Static) -> Any:
        signed = -1.0 if str(static.value).startswith("-") else 1.0
        return x * signed * (2.0 if type(static.value) is bool else 1.0) + isinstance(
            static.value, float
        )

    mapped = lanes.vmap(function, in_axes=(0, None))
    for value in (one, other):
        expected = jax.vmap(lambda x, value=value: function(x, Static(value)))(X)
        np.testing.assert_array_equal(mapped(X, Static(value)), expected)


def test_static_arrays_are_told_apart() -> None:
    mapped = lanes.vmap(lambda x, static: x * static.value[5000], in_axes=(0, None))
    for factor in (2.0, 3.0):
        values = np.zeros(10_000)
        values[5000] = factor
        np.testing.assert_array_equal(mapped(X, Static(values)), factor * X)


def test_configuration_of_jax_is_part_of_what_is_compiled() -> None:
    mapped = lanes.vmap(lambda x: x + jax.random.uniform(jax.random.key(0)))
    results = {
        implementation: _with(implementation, mapped) for implementation in ("threefry2x32", "rbg")
    }
    for implementation, result in results.items():
        with jax.default_prng_impl(implementation):
            np.testing.assert_allclose(result, X + jax.random.uniform(jax.random.key(0)))
    assert results["rbg"][0] != results["threefry2x32"][0]


def _with(implementation: str, mapped: Any) -> Any:
    with jax.default_prng_impl(implementation):
        return mapped(X)


def test_an_empty_closure_cell_is_no_obstacle() -> None:
    def make(k: float | None) -> Any:
        if k is not None:
            unset = k

        def function(x: Any) -> Any:
            return x * (unset if k is not None else 1.0)  # pyright: ignore

        return function

    np.testing.assert_array_equal(lanes.vmap(make(None))(X), X)


TASK = """
import dataclasses

SCALE = 1.0

@dataclasses.dataclass(frozen=True)
class Task:
    factor: float
    test_settings: dict = dataclasses.field(default_factory=dict)

    def rollout(self, x):
        return x * self.factor * SCALE
"""

PROGRAM = """
import sys
from mjxwalk import own_process
{before}
if {declared}:
    own_process.declare()
import numpy as np
from mjxwalk.engines import lanes
from mjxwalk.engines.lanes import compiler
from mjxwalk.task import Task
traces = []
original = compiler.trace
compiler.trace = lambda *args, **more: (traces.append(1), original(*args, **more))[1]
mapped = lanes.vmap(Task(float(sys.argv[1])).rollout, results=0)
print(mapped(np.ones(4, np.float32))[0], len(traces))
"""


class Copy:
    """A copy of the package with a task in it, run in processes of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        source = Path(mjxwalk.__file__).parent
        left_out = shutil.ignore_patterns("__pycache__", "bundle", "zoo", "envs", "strategies")
        shutil.copytree(source, folder / "mjxwalk", ignore=left_out)
        for part in (mjxwalk.envs, mjxwalk.strategies):
            inside = Path(part.__path__[0])
            shutil.copytree(inside, folder / "mjxwalk" / inside.name, ignore=left_out)
        self.task = folder / "mjxwalk" / "task.py"
        self.task.write_text(TASK)

    def run(self, factor: float, *, declared: bool = True, before: str = "") -> tuple[float, int]:
        """Returns a result and how many functions were traced for it."""
        env = {**os.environ, "PYTHONPATH": str(self.folder)}
        env["XDG_CACHE_HOME"] = str(self.folder / "cache")
        env.pop("PYTHONDONTWRITEBYTECODE", None)
        program = PROGRAM.format(declared=declared, before=before)
        done = subprocess.run(
            [sys.executable, "-c", program, str(factor)],
            cwd=self.folder, env=env, capture_output=True, text=True, timeout=300, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        value, traces = done.stdout.split()
        return float(value), int(traces)


@pytest.fixture
def copy(tmp_path: Path) -> Copy:
    """A package that may be edited, whose files have been there for a while."""
    made = Copy(tmp_path)
    made.run(9.0)  # writes compiled files of Python
    made.run(9.0)
    return made


def test_program_finds_kernels_of_its_settings_without_tracing(copy: Copy) -> None:
    assert copy.run(2.0) == (2.0, 1)
    assert copy.run(2.0) == (2.0, 0)
    assert copy.run(3.0) == (3.0, 1)
    assert copy.run(2.0, declared=False) == (2.0, 1)  # in a process of somebody else's
    user = copy.folder / "user"
    user.mkdir()
    (user / "tool.py").write_text("import mjxwalk.task\nmjxwalk.task.SCALE = 5.0\n")
    before = f"sys.path.append({str(user)!r}); import tool"
    assert copy.run(2.0, before=before) == (10.0, 1)  # a user's module has been loaded


def test_program_finds_no_kernel_of_sources_that_were_edited_in_place(copy: Copy) -> None:
    assert copy.run(2.0) == (2.0, 1)
    stamp = copy.task.stat()
    # Of the same size, with the old time stamp: Python itself runs its old compiled file.
    copy.task.write_text(TASK.replace("SCALE = 1.0", "SCALE = 3.0"))
    os.utime(copy.task, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    assert copy.run(2.0)[0] == 2.0
    shutil.rmtree(copy.folder / "mjxwalk" / "__pycache__")
    assert copy.run(2.0)[0] == 6.0
    assert copy.run(2.0)[0] == 6.0


def test_program_finds_no_kernel_where_python_runs_another_compiled_file(copy: Copy) -> None:
    assert copy.run(2.0) == (2.0, 1)
    edited = TASK.replace("SCALE = 1.0", "SCALE = 3.0")
    stamp = copy.task.stat()
    code = compile(edited, str(copy.task), "exec")
    header = importlib.util.MAGIC_NUMBER + struct.pack(
        "<LLL", 0, int(stamp.st_mtime), stamp.st_size
    )
    compiled = Path(importlib.util.cache_from_source(str(copy.task)))
    compiled.write_bytes(header + marshal.dumps(code))
    assert copy.run(2.0)[0] == 6.0


def test_script_that_changes_the_package_and_runs_the_program_is_traced(copy: Copy) -> None:
    assert copy.run(2.0) == (2.0, 1)
    before = "import jax, mjxwalk.task; mjxwalk.task.SCALE = 5.0"
    assert copy.run(2.0, before=before) == (10.0, 1)


def test_what_is_no_file_beside_the_sources_is_no_obstacle(copy: Copy) -> None:
    (copy.folder / "mjxwalk" / ".#task.py").symlink_to("somebody@somewhere.1")  # as Emacs locks
    assert copy.run(2.0) == (2.0, 1)
    (copy.folder / "mjxwalk" / ".#task.py").unlink()
    os.mkfifo(copy.folder / "mjxwalk" / "pipe")
    assert copy.run(2.0) == (2.0, 1)


def test_program_in_an_archive_is_traced(copy: Copy) -> None:
    package = copy.folder / "mjxwalk"
    archive = str(copy.folder / "app.zip")
    program = f"import sys; sys.path.insert(0, {archive!r})\n"
    program += PROGRAM.format(declared=True, before="")
    env = {**os.environ, "XDG_CACHE_HOME": str(copy.folder / "cache")}
    for scale in (1.0, 3.0):
        copy.task.write_text(TASK.replace("SCALE = 1.0", f"SCALE = {scale}"))
        shutil.make_archive(archive.removesuffix(".zip"), "zip", copy.folder, "mjxwalk")
        package.rename(copy.folder / "aside")
        done = subprocess.run(
            [sys.executable, "-c", program, "2.0"],
            cwd=copy.folder, env=env, capture_output=True, text=True, timeout=300, check=False,
        )  # fmt: skip
        assert done.stdout.split() == [str(2.0 * scale), "1"], done.stderr
        (copy.folder / "aside").rename(package)
