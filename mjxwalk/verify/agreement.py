"""How well C MuJoCo and an engine agree on what a walker does."""

from typing import Any

import msgspec
import numpy as np

from mjxwalk.outcomes import cost_of_transport
from mjxwalk.rollout import Outcome

# ours: as far apart as one gait is at steps of 1 ms and of a quarter of it (docs/physics.md); which
# of the rare stumbles on rough ground end in a fall hangs on the last digit.
MOST_APART = 0.02  # of the mean distance
MOST_APART_COST = 0.05  # of the cost of transport
MOST_OTHER_ENDS = 0.05  # of the trials


class Side(msgspec.Struct, frozen=True, kw_only=True):
    """What the walker does by one of the two.

    Attributes:
      name: of the engine, or "C MuJoCo".
      distance_m: of each trial.
      fell: whether each trial ended by a fall.
      duration_s: of each trial.
      distance_mean_m: over all trials.
      fall_rate: share of the trials.
      cost_of_transport: work over weight times distance of all trials; None if it got nowhere.
    """

    name: str
    distance_m: tuple[float, ...]
    fell: tuple[bool, ...]
    duration_s: tuple[float, ...]
    distance_mean_m: float
    fall_rate: float
    cost_of_transport: float | None


class Agreement(msgspec.Struct, frozen=True, kw_only=True):
    """A walker's trials by an engine and by C MuJoCo, on the same terrains.

    Attributes:
      walker: its source.
      generation: in which it was the fittest.
      seed: of the terrains.
      roughness_m: of the terrains.
      engine: its side.
      reference: C MuJoCo's.
      distance_apart: difference of the mean distances, as a share of the reference's.
      trial_apart: median over the trials of the difference in distance, as a share of the
        reference's mean.
      cost_apart: difference of the costs of transport, as a share; None if either has none.
      other_ends: trials that ended by a fall for one of them only.
      agrees: whether all of these are within their limits.
    """

    walker: str
    generation: int
    seed: int
    roughness_m: float
    engine: Side
    reference: Side
    distance_apart: float
    trial_apart: float
    cost_apart: float | None
    other_ends: int
    agrees: bool


def side(name: str, outcome: Outcome, weight: float) -> Side:
    """Returns the figures of outcomes [trial].

    Args:
      name: of whose they are.
      outcome: numpy arrays.
      weight: of the body, N.
    """
    distance = np.asarray(outcome.distance, np.float64)
    fell = np.asarray(outcome.fell)
    return Side(
        name=name,
        distance_m=tuple(distance.tolist()),
        fell=tuple(fell.tolist()),
        duration_s=tuple(np.asarray(outcome.duration, np.float64).tolist()),
        distance_mean_m=float(distance.mean()),
        fall_rate=float(fell.mean()),
        cost_of_transport=cost_of_transport(outcome.work, distance, weight),
    )


def compare(engine: Side, reference: Side, **told: Any) -> Agreement:
    """Returns how far apart the two are.

    Args:
      engine: what evolved the walker.
      reference: C MuJoCo.
      told: what else an `Agreement` holds on the walker and its terrains.
    """
    scale = max(abs(reference.distance_mean_m), 1e-9)
    each = np.abs(np.subtract(engine.distance_m, reference.distance_m))
    distance_apart = abs(engine.distance_mean_m - reference.distance_mean_m) / scale
    one, other = engine.cost_of_transport, reference.cost_of_transport
    cost_apart = None if one is None or other is None else abs(one - other) / other
    other_ends = int(np.sum(np.not_equal(engine.fell, reference.fell)))
    same_cost = one is other is None or (cost_apart is not None and cost_apart <= MOST_APART_COST)
    return Agreement(
        engine=engine,
        reference=reference,
        distance_apart=float(distance_apart),
        trial_apart=float(np.median(each)) / scale,
        cost_apart=cost_apart,
        other_ends=other_ends,
        agrees=bool(
            distance_apart <= MOST_APART
            and same_cost
            and other_ends <= MOST_OTHER_ENDS * len(engine.fell)
        ),
        **told,
    )
