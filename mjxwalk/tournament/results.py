"""What a tournament came to, as the files `tournament.json` and `winner.npz` in a run's folder."""

from pathlib import Path
from typing import Any

import msgspec
import numpy.typing as npt

from mjxwalk.errors import RunError
from mjxwalk.runs import digests, files, owner
from mjxwalk.runs.npz import MOST_BYTES, from_npz, npz

FILE = "tournament.json"
WINNER_FILE = "winner.npz"
AS_EVOLVED = "as evolved"
HALF_STEP = "half the time step"
PAPERS_STEP = "the paper's explicit step"
PERTURBED = "perturbed starts"


class Condition(msgspec.Struct, frozen=True, kw_only=True):
    """What the winner does under one set of conditions. A figure without a value is None.

    Attributes:
      name: of the conditions.
      trials: each on a terrain of its own; the same terrains under all conditions.
      distance_mean_m: over all trials.
      distance_sd_m: between trials.
      fall_rate: share of the trials that ended by a fall.
      fall_rate_low: lower end of its 95 % interval (Wilson).
      fall_rate_high: upper end.
      cost_of_transport: work over weight times distance of all trials.
      speed_m_s: mean over the trials without fall, as the next two.
      step_length_m: from one foot to the other at touch-down, along the ground.
      double_stance: share of the time in which both feet are on the ground.
    """

    name: str
    trials: int
    distance_mean_m: float
    distance_sd_m: float
    fall_rate: float
    fall_rate_low: float
    fall_rate_high: float
    cost_of_transport: float | None
    speed_m_s: float | None
    step_length_m: float | None
    double_stance: float | None


class Tournament(msgspec.Struct, frozen=True, kw_only=True):
    """A winner, how it was found, and what it does on terrains that played no part in that.

    Attributes:
      entrants: walkers that were compared.
      newest_generation: of the youngest entrant.
      winner_generation: in which the winner was the fittest.
      screening_terrains: on which the entrants were compared; 0 where there was one only.
      seed: of all terrains and starts.
      engine: that ran the trials.
      roughness_m: step of the random terrain; None where the ground has no such setting.
      conditions: "as evolved" first.
    """

    entrants: int
    newest_generation: int
    winner_generation: int
    screening_terrains: int
    seed: int
    engine: str
    roughness_m: float | None
    conditions: tuple[Condition, ...]

    def condition(self, name: str) -> Condition | None:
        """Returns the figures under the named conditions, None if it was not tried under them."""
        return next((each for each in self.conditions if each.name == name), None)


class _File(Tournament, frozen=True, kw_only=True, forbid_unknown_fields=True):
    digest: str | None = None
    run: str | None = None
    weights: str | None = None  # digest of the winner's file


def write(folder: Path, tournament: Tournament, arrays: dict[str, npt.NDArray[Any]]) -> None:
    """Writes the winner's weights by name, then the figures.

    Raises:
      RunError: the files cannot be written, for example because the disk is full.
    """
    weights = npz(arrays)
    told = {**msgspec.to_builtins(tournament), "weights": digests.of_bytes(weights)}
    content = owner.with_digest(folder, told)
    # Figures without their winner would be another's; between the two files there are none.
    files.remove(folder, FILE)
    files.replace(folder, WINNER_FILE, weights)
    files.replace(folder, FILE, content)


def read(folder: Path) -> Tournament | None:
    """Returns a run's tournament, None if none was held.

    Raises:
      RunError: the file is not what a tournament writes, was changed, or is of another run.
    """
    file = _read(folder)
    if file is None:
        return None
    return Tournament(**{name: getattr(file, name) for name in Tournament.__struct_fields__})


def read_winner(folder: Path) -> dict[str, npt.NDArray[Any]]:
    """Returns the winner's weights by name.

    Raises:
      RunError: there are none, or the file is damaged or that of another tournament.
    """
    path, content = folder / WINNER_FILE, files.read_inside(folder, WINNER_FILE, MOST_BYTES)
    if content is None:
        raise RunError(f"{path} does not exist")
    file = _read(folder)
    if file is not None and file.weights is not None:
        owner.check_content(path, content, file.weights)
    return from_npz(path, content)


def _read(folder: Path) -> _File | None:
    content = owner.read(folder, FILE)
    return None if content is None else files.decode(folder / FILE, content, _File)
