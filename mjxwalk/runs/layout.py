"""What Orbax puts around an array of bytes, taken from an example that it writes itself.

Only the array's content and size and the metadata differ from one checkpoint to the next.
"""

import functools
import logging
import os
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from mjxwalk.runs import files

ARRAY = "arrays"  # name of the array of bytes
CONTENT = f"{ARRAY}/0"  # its only chunk, not compressed
HEADER = f"{ARRAY}/.zarray"
METADATA = "_CHECKPOINT_METADATA"


def _is_news(record: logging.LogRecord) -> bool:
    # Orbax 0.12 warns at each save without OCDBT that there is nothing of OCDBT to merge.
    return "Skipping merge of OCDBT" not in record.getMessage()


logging.getLogger("absl").addFilter(_is_news)


def fill(folder: Path, name: str, content: npt.NDArray[np.uint8], told: object) -> None:
    """Makes a checkpoint in a new folder, and returns when all of it is on the disk.

    Args:
      folder: of the run.
      name: of the checkpoint's folder in it, which is made.
      content: of the array.
      told: what the checkpoint says of itself, besides what Orbax does.

    Raises:
      OSError: the disk is full, or a file is there.
      RunError: the folder cannot be made, or a link is in the way.
    """
    around = example()
    now = time.time_ns()
    written = {
        **around,
        HEADER: _changed(around[HEADER], shape=[content.size], chunks=[content.size]),
        METADATA: _changed(
            around[METADATA],
            init_timestamp_nsecs=now,
            commit_timestamp_nsecs=now,
            custom_metadata=msgspec.to_builtins(told),
        ),
        CONTENT: content.data,
    }
    folders = {os.path.dirname(f"{name}/{inside}") for inside in written}
    for each in sorted({name, *folders}):
        files.make_folder(folder, each)
    for inside, data in written.items():
        files.create(folder, f"{name}/{inside}", data)
    for each in folders:
        files.sync(folder, each)


def _changed(text: bytes, **changes: object) -> bytes:
    return msgspec.json.encode(msgspec.json.decode(text, type=dict[str, Any]) | changes)


@functools.cache
def example() -> Mapping[str, bytes]:
    """Returns the files of a checkpoint by path, without the array's content."""
    import jax  # reading does without
    import orbax.checkpoint as ocp

    # In a run of several processes one writes, and the others know nothing of it.
    me = jax.process_index()
    alone = ocp.options.MultiprocessingOptions(primary_host=me, active_processes={me})
    handler = ocp.PyTreeCheckpointHandler(
        use_ocdbt=False, use_compression=False, multiprocessing_options=alone
    )
    with tempfile.TemporaryDirectory(prefix="mjxwalk-") as place:
        path = Path(place) / "example"
        with ocp.Checkpointer(handler, multiprocessing_options=alone) as orbax:
            orbax.save(path, ocp.args.PyTreeSave({ARRAY: np.zeros(1, np.uint8)}))
        found = {str(p.relative_to(path)): p for p in sorted(path.rglob("*")) if p.is_file()}
        if found.pop(CONTENT, None) is None or not {HEADER, METADATA} <= set(found):
            raise RuntimeError(f"Orbax has another layout now: {sorted(found)}")
        return {name: file.read_bytes() for name, file in found.items()}
