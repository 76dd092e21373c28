"""Evaluates populations: every genotype on every terrain, by an engine."""

from typing import Any, Protocol, runtime_checkable

import jax
import numpy as np

from mjxwalk import engines
from mjxwalk.engines import lanes, mjx
from mjxwalk.engines.pinning import pinned
from mjxwalk.envs import Terrain
from mjxwalk.rollout import Outcome

# Terrains come in tables of a multiple of so many rows, so that engines, which compile for shapes,
# compile once for most numbers of terrains.
TABLE_ROWS = 512

OUTCOME = Outcome._make(range(len(Outcome._fields)))  # what a rollout returns, as a tree


@runtime_checkable
class Task(Protocol):
    """What can be evaluated: an experiment, or the least part of one."""

    def rollout(self, genotype: Any, terrain: Terrain) -> Outcome:
        """Returns what one walker does on one terrain."""
        ...


class Evaluator:
    """Runs a task's rollout for populations.

    Attributes:
      engine: name of the engine that runs.
      why: why this engine, in words.
      devices: what it runs on, in words.
    """

    def __init__(self, task: Task, engine: str) -> None:
        self.engine, self.why = engines.choose(engine)
        in_axes: Any = (0, Terrain(None, 0))  # type: ignore[arg-type]
        if self.engine == "lanes":
            self._run = lanes.vmap(task.rollout, in_axes, results=OUTCOME)
            self.devices = f"{self._run.threads} CPU threads"
        else:
            vmap = lanes.xla_vmap if self.engine == "lanes-xla" else mjx.vmap
            self._run = vmap(task.rollout, in_axes)
            self.devices = f"{len(jax.devices())} x {jax.devices()[0].device_kind}"

    @property
    def compile_s(self) -> float:
        """Seconds spent compiling so far."""
        if isinstance(self._run, mjx.Mapped):
            return self._run.compile_s
        return self._run.compiled.seconds if self._run.compiled else 0.0

    @pinned()
    def prepare(self, population: Any, heights: Any) -> None:
        """Compiles for arguments of `evaluate` of these shapes, as far as the engine can.

        Args:
          population: anything with the shapes and types of the genotypes.
          heights: likewise of the terrains.
        """
        if isinstance(self._run, lanes.Mapped):
            num_terrains, size = heights.shape[0], jax.tree.leaves(population)[0].shape[0]
            rows = jax.ShapeDtypeStruct((size * num_terrains,), np.int32)
            table = jax.ShapeDtypeStruct(
                (_table_rows(num_terrains), *heights.shape[1:]), np.float32
            )
            repeated = jax.tree.map(
                lambda w: jax.ShapeDtypeStruct((size * num_terrains, *w.shape[1:]), w.dtype),
                population,
            )
            self._run.compile(repeated, Terrain(table, rows))  # type: ignore[arg-type]

    @pinned()
    def evaluate(self, population: Any, heights: Any) -> Outcome:
        """Returns the outcomes as numpy arrays [pop, terrain].

        Args:
          population: genotypes, leaves [pop, ...].
          heights: one terrain a row, m.

        Raises:
          ValueError: there is no genotype or no terrain, or leaves differ in how many they hold.
        """
        population, heights = jax.tree.map(_on_host, population), _on_host(heights)
        shapes = [leaf.shape for leaf in jax.tree.leaves(population)]
        sizes = {shape[:1] for shape in shapes}
        if len(sizes) != 1 or sizes & {(), (0,)}:
            raise ValueError(f"population must have genotypes in front of all leaves, got {shapes}")
        if not heights.ndim or not heights.shape[0]:
            raise ValueError(f"heights must hold one terrain a row, got shape {heights.shape}")
        num_terrains = heights.shape[0]
        table = np.zeros((_table_rows(num_terrains), *heights.shape[1:]), np.float32)
        table[:num_terrains] = heights
        repeated = jax.tree.map(lambda w: np.repeat(w, num_terrains, 0), population)
        size = jax.tree.leaves(repeated)[0].shape[0]
        rows: Any = np.arange(size, dtype=np.int32) % num_terrains
        ground: Any = Terrain(table, rows)  # type: ignore[arg-type]
        outcome = self._run(repeated, ground)
        return jax.tree.map(lambda leaf: np.asarray(leaf).reshape(-1, num_terrains), outcome)


def _on_host(values: Any) -> np.ndarray:
    """Returns numbers as NumPy's, of the dtype that JAX would give them."""
    array = np.asarray(values)
    return array.astype(jax.dtypes.canonicalize_dtype(array.dtype), copy=False)


def _table_rows(num_terrains: int) -> int:
    return -(-num_terrains // TABLE_ROWS) * TABLE_ROWS


def make_evaluator(task: Task, engine: str) -> Evaluator:
    """Returns an evaluator of the task by the named engine.

    Raises:
      ValueError: there is no such engine.
    """
    return Evaluator(task, engine)
