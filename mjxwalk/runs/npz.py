"""Named arrays in an npz file, which may come from anybody when it is read.

Nothing in it is run, and nothing is allocated that the file does not hold: `numpy.load` asks for as
much memory as the header of an array tells it to.
"""

import io
import math
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from mjxwalk.errors import RunError
from mjxwalk.runs import files

MOST_BYTES = 1 << 30  # ours: of a file; a population of 10,000 spatial walkers takes a quarter


def npz(arrays: Mapping[str, npt.NDArray[Any]]) -> bytes:
    """Returns the content of an npz file that is the same for the same arrays.

    `numpy.savez` writes the time of day into it, and refuses an array named "file".
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, array in arrays.items():
            with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w") as file:
                np.lib.format.write_array(file, np.asarray(array), allow_pickle=False)
    return buffer.getvalue()


def read_npz(path: Path) -> dict[str, npt.NDArray[Any]]:
    """Returns the arrays of an npz file that the user named, or that ships with mjxwalk, by name.

    Raises:
      RunError: it cannot be read, is damaged, or holds what `npz` does not write.
    """
    return from_npz(path, files.read(path, MOST_BYTES))


def from_npz(path: Path, content: bytes) -> dict[str, npt.NDArray[Any]]:
    """Returns the arrays of an npz file by name.

    Args:
      path: of the file, for the complaint.
      content: of the file.

    Raises:
      RunError: it is damaged, or holds what `npz` does not write: compressed or other than numbers.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = archive.infolist()
            if any(member.compress_type != zipfile.ZIP_STORED for member in members):
                raise ValueError("it is compressed")
            if sum(member.file_size for member in members) > len(content):
                raise ValueError("its members overlap")
            if len({member.filename for member in members}) < len(members):
                raise ValueError("it has two members of one name")
            return {
                member.filename.removesuffix(".npy"): array(archive.read(member))
                for member in members
            }
    except Exception as error:  # zipfile and numpy each raise their own on damaged bytes
        reason = str(error).splitlines() or [type(error).__name__]
        raise RunError(f"{path} is damaged ({reason[0]})") from None


def array(content: bytes) -> npt.NDArray[Any]:
    """Returns the array of an npy file.

    Raises:
      ValueError: it holds other than numbers, or another amount of them than it says.
    """
    file = io.BytesIO(content)
    if np.lib.format.read_magic(file) != (1, 0):
        raise ValueError("it is of another version of NumPy's format")
    shape, transposed, dtype = np.lib.format.read_array_header_1_0(file)
    if dtype.kind not in "biuf":
        raise ValueError(f"it holds {dtype}, which are not plain numbers")
    numbers = content[file.tell() :]
    if math.prod(shape) * dtype.itemsize != len(numbers):
        raise ValueError(f"it holds {len(numbers)} bytes for {dtype}{list(shape)}")
    flat = np.frombuffer(numbers, dtype).copy()
    return flat.reshape(shape[::-1]).T if transposed else flat.reshape(shape)
