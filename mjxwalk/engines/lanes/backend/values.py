"""The names of nodes' values in the block that is being written."""

from collections.abc import Generator
from contextlib import contextmanager

from mjxwalk.engines.lanes.backend.workspace import Layout, Workspace
from mjxwalk.engines.lanes.backend.writer import Writer
from mjxwalk.engines.lanes.ir.graph import Graph


class Values:
    """A name for every node that has been computed; constants have none, nor what is still kept."""

    def __init__(self, graph: Graph, writer: Writer, workspace: Workspace, layout: Layout) -> None:
        self._graph = graph
        self._writer = writer
        self._workspace = workspace
        self._layout = layout
        self._names: dict[int, str] = {}

    def __contains__(self, node_id: int) -> bool:
        return node_id in self._names

    def __getitem__(self, node_id: int) -> str:
        """Returns a node's name or constant; reads what an earlier block left in the workspace."""
        known = self._graph.value(node_id)
        if known is not None:
            return self._writer.splat(known, known.dtype.name)
        if node_id not in self._names:
            dtype = self._graph.dtype(node_id)
            self._names[node_id] = self._workspace.read(self._layout.offset_of(node_id), dtype)
        return self._names[node_id]

    def __setitem__(self, node_id: int, name: str) -> None:
        self._names[node_id] = name

    def clear(self) -> None:
        """Forgets all names, where a block begins that the earlier ones do not lead to."""
        self._names.clear()

    @contextmanager
    def scope(self) -> Generator[None]:
        """Forgets in the end the names that were given within."""
        outer = dict(self._names)
        yield
        self._names = outer
