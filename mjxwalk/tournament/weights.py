"""Reads the weights of one walker from a file that may come from anybody.

Nothing in the file is run, and nothing is allocated that the file does not hold.
"""

import io
import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from mjxwalk.errors import RunError
from mjxwalk.runs import files

MOST_BYTES = 1 << 20  # ours: a thousand times a planar walker; stops an archive that swells


def read(path: Path) -> dict[str, npt.NDArray[Any]]:
    """Returns the arrays of an npz file by name.

    Raises:
      RunError: there is no such file, or it is damaged, too big, or holds more than plain numbers.
    """
    if not path.exists():
        raise RunError(f"{path} does not exist")
    content = files.read(path)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = archive.infolist()
            total = sum(member.file_size for member in members)
            if total > MOST_BYTES:
                raise ValueError(f"it holds {total} bytes, more than {MOST_BYTES}")
            return {
                member.filename.removesuffix(".npy"): _array(archive.read(member))
                for member in members
            }
    except Exception as error:  # zipfile, zlib and numpy each raise their own on damaged bytes
        raise RunError(f"{path} is damaged ({error})") from None


def _array(content: bytes) -> npt.NDArray[Any]:
    file = io.BytesIO(content)
    if np.lib.format.read_magic(file) != (1, 0):
        raise ValueError("it is of another version of NumPy's format")
    shape, transposed, dtype = np.lib.format.read_array_header_1_0(file)
    if dtype.kind not in "bif":
        raise ValueError(f"it holds {dtype}, which are not plain numbers")
    numbers = content[file.tell() :]
    if math.prod(shape) * dtype.itemsize != len(numbers):
        raise ValueError(f"it holds {len(numbers)} bytes for {dtype}{list(shape)}")
    array = np.frombuffer(numbers, dtype)
    return array.reshape(shape[::-1]).T if transposed else array.reshape(shape)
