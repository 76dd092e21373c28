"""Which run a file is of: the files of a run name the digest of its settings.

Two runs with the same settings are the same run, wherever they took place.
"""

from pathlib import Path
from typing import NamedTuple

from mjxwalk.errors import RunError
from mjxwalk.runs import config, digests, files

RUN = "run"  # what a file calls it


class Owner(NamedTuple):
    """The run of a folder.

    Attributes:
      digest: of its settings; "" where there is no run.
      is_named: whether each of its files must name it; those of older versions do not.
    """

    digest: str
    is_named: bool

    def check(self, path: Path, found: object) -> None:
        """Raises RunError unless a file is this run's.

        Args:
          path: of the file, for the complaint.
          found: the digest that it names, None for none.
        """
        if found is None and not self.is_named:
            return
        if found != self.digest:
            raise RunError(
                f"{path} is of another run than the settings beside it; put back the file of this "
                "run"
            )


def of(folder: Path) -> Owner:
    """Returns the run that a folder's files have to be of.

    Raises:
      RunError: its `config.json` cannot be read.
    """
    content = files.read_inside(folder, config.FILE, files.MOST_JSON)
    if content is None:
        return Owner("", is_named=False)
    data = files.decode_table(folder / config.FILE, content)
    return Owner(digests.of_table(data), is_named=data.get("schema") not in config.UNNAMED)


def check_content(path: Path, content: bytes, expected: str) -> None:
    """Raises RunError unless a file has the content whose digest another file of its run holds."""
    if digests.of_bytes(content) != expected:
        raise RunError(
            f"{path} is not the file that its run wrote: its contents do not match their digest in "
            "the file that belongs to it"
        )


def with_digest(folder: Path, data: object) -> bytes:
    """Returns the content of a JSON file of the run in a folder, with digests of it and of the run.

    Raises:
      RunError: the run's settings cannot be read.
    """
    return digests.with_digest(data, run=of(folder).digest)


def read(folder: Path, name: str) -> bytes | None:
    """Returns the content of a JSON file that `with_digest` made, None if it is not there.

    Older versions of mjxwalk put no digest in tournaments, and named the run in no file.

    Raises:
      RunError: it cannot be read, was changed, or is of another run.
    """
    content = files.read_inside(folder, name, files.MOST_JSON)
    if content is not None:
        path, owner = folder / name, of(folder)
        digests.check(path, content, needed=owner.is_named)
        owner.check(path, files.decode_table(path, content).get(RUN))
    return content
