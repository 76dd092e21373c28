"""The command `mjxwalk bench`."""

import dataclasses
import time
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from mjxwalk.errors import RunError


@dataclasses.dataclass(frozen=True, kw_only=True)
class Bench:
    """Measure engines, or strategies, against each other and against those of others.

    Attributes:
      subject: engines, against C MuJoCo and the CPU's peak; or strategies, against evosax and
        pycma.
      quick: measure less, in about a minute.
      xla: measure the engine lanes-xla also where JAX has only CPUs, for which it compiles slowly.
      json: file to write the numbers to; an old one is replaced.
    """

    subject: tyro.conf.Positional[Literal["engines", "strategies"]] = "engines"
    quick: bool = False
    xla: bool = False
    json: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None

    def run(self) -> int:
        """Measures, prints and returns the exit code.

        Raises:
          RunError: the file cannot be written; found out before anything is measured.
        """
        if self.json is not None:
            check_writable(self.json)
        if self.subject == "strategies":
            return self._compare_strategies()
        from mjxwalk import engines

        engines.prepare()
        from mjxwalk.bench import measuring, results, showing

        started = time.perf_counter()
        sizes = measuring.QUICK if self.quick else measuring.FULL
        measured = measuring.measure(dataclasses.replace(sizes, xla=self.xla), _say)
        if self.json is not None:
            write(self.json, results.as_json(measured))
        showing.show(measured)
        wrote = "" if self.json is None else f", wrote {self.json}"
        _say(f"took {time.perf_counter() - started:.0f} s{wrote}")
        return 0

    def _compare_strategies(self) -> int:
        from mjxwalk.bench import comparing

        try:
            numbers = comparing.measure_and_show(self.quick, _say)
        except ImportError as error:
            raise RunError(
                f"comparing strategies needs evosax, pip install evosax: {error}"
            ) from None
        if self.json is not None:
            write(self.json, numbers)
        return 0


def check_writable(path: Path) -> None:
    """Finds out whether a file could be written, and leaves it as it was.

    Raises:
      RunError: it could not.
    """
    was_there = path.exists()
    try:
        with path.open("ab"):
            pass
        if not was_there:
            path.unlink()
    except OSError as error:
        raise _refusal(path, error) from None


def write(path: Path, data: dict[str, Any]) -> None:
    """Writes data as JSON.

    Raises:
      RunError: the disk is full, or the file cannot be written.
    """
    import msgspec

    try:
        path.write_bytes(msgspec.json.format(msgspec.json.encode(data), indent=2) + b"\n")
    except OSError as error:
        raise _refusal(path, error) from None


def _refusal(path: Path, error: OSError) -> RunError:
    why = (error.strerror or str(error)).lower()
    return RunError(f"--json {path} cannot be written: {why}")


def _say(text: str) -> None:
    print(text, flush=True)
