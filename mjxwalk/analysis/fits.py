"""How well oscillators draw a human's angles: root mean squares over the gait cycle, in degrees.

At first: over the cycles that an experiment is fitted to, from its start on and by the human's
clock. Settled: over one cycle of the oscillators' own, long after the start, shifted in time as a
whole to where it fits best; a limit cycle has no other phase.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.controllers.rayleigh import JOINTS, LEFT_HIP
from mjxwalk.gaits import NUM_POINTS

SETTLED_CYCLES = 100  # ours: the thesis' hips take some 20 to a tenth of what they were off

DENSITY = 20  # points that a cycle is compared at, for each sample


class Fit(NamedTuple):
    """What oscillators draw, beside what they should.

    Attributes:
      human: degrees, left hip, right hip, left knee, right knee; of one cycle.
      angle: of the oscillators at every percent of the human's cycle from the start on, degrees.
      rate: degrees/s.
      cycle: one of their own cycles once they have settled, NaN where they have none.
      period: of it, over that of the human.
      rms: of angles, at first, degrees.
      settled_rms: of the cycle, degrees.
    """

    human: Float[np.ndarray, "100 4"]
    angle: Float[np.ndarray, "time 4"]
    rate: Float[np.ndarray, "time 4"]
    cycle: Float[np.ndarray, "100 4"]
    period: float
    rms: Float[np.ndarray, "4"]
    settled_rms: Float[np.ndarray, "4"]

    def by_joint(self) -> dict[str, float]:
        """Returns the root mean square of each joint at first, degrees."""
        return dict(zip(JOINTS, map(float, self.rms), strict=True))


def measure(experiment: Any, genotype: Any, *, start: Any = None) -> Fit:
    """Returns how well a genotype of a `RayleighFit` does.

    Args:
      experiment: its gait and its cycles.
      genotype: to measure.
      start: state to begin in; None for the experiment's own.
    """
    human = experiment.target().four_joints
    first = experiment.settling_cycles * NUM_POINTS
    num = experiment.settling_cycles + experiment.cycles
    motion = experiment.simulate(genotype, num + SETTLED_CYCLES, start)
    angle, rate = (np.asarray(part, np.float64) for part in motion)
    fitted = slice(first, num * NUM_POINTS)
    cycle, period = last_cycle(angle)
    cycle = _shifted(cycle, human)
    off = angle[fitted] - np.tile(human, (experiment.cycles, 1))
    return Fit(
        human=human,
        angle=angle[fitted],
        rate=rate[fitted],
        cycle=cycle,
        period=period,
        rms=_rms(off),
        settled_rms=_rms(cycle - human),
    )


class Kicked(NamedTuple):
    """A limit cycle that was left and found again.

    Attributes:
      cycle: before, degrees and degrees/s, [time, joint]; of two of the human's cycles.
      cycle_rate: of the same.
      angle: from the kick on, degrees.
      rate: degrees/s.
      distance: of each of the human's cycles after the kick to the cycle before: the farthest of
        its points, as the largest difference of the four angles to the nearest point, degrees.
    """

    cycle: Float[np.ndarray, "200 4"]
    cycle_rate: Float[np.ndarray, "200 4"]
    angle: Float[np.ndarray, "time 4"]
    rate: Float[np.ndarray, "time 4"]
    distance: Float[np.ndarray, " cycle"]


def kick(experiment: Any, genotype: Any, *, factor: float, cycles: int = 20) -> Kicked:
    """Returns what settled oscillators do once the left leg's have been kicked.

    Args:
      experiment: a `RayleighFit`.
      genotype: of it.
      factor: on their angles about the centres and on their rates.
      cycles: of the human that are followed.
    """
    settled = experiment.settle(genotype, SETTLED_CYCLES)
    network, _ = experiment.network.begin(genotype, experiment.target())
    kicked = experiment.network.kick(network, settled, factor)
    before, after = (
        [np.asarray(part, np.float64) for part in experiment.simulate(genotype, num, state)]
        for num, state in ((2, settled), (cycles, kicked))
    )
    # A knee moves by four degrees between two samples.
    samples = np.arange(len(before[0]))
    between = np.linspace(0, len(samples) - 1, DENSITY * len(samples))
    dense = np.stack([np.interp(between, samples, joint) for joint in before[0].T], axis=1)
    near = [np.min(np.max(np.abs(dense - point), axis=1)) for point in after[0]]
    return Kicked(
        cycle=before[0],
        cycle_rate=before[1],
        angle=after[0],
        rate=after[1],
        distance=np.max(np.reshape(near, (cycles, NUM_POINTS)), axis=1),
    )


def settled_state(experiment: Any, genotype: Any, cycles: int) -> Any:
    """Returns where settled oscillators are when the human's left heel strikes.

    That is the network's state, of all in one cycle after these many the one from which the angles
    fit best.
    """
    human = experiment.target().four_joints
    state = experiment.settle(genotype, cycles)
    angle = np.asarray(experiment.simulate(genotype, 2, state).angle, np.float64)
    errors = [np.sum((angle[n : n + NUM_POINTS] - human) ** 2) for n in range(NUM_POINTS)]
    return experiment.settle_steps(genotype, state, int(np.argmin(errors)))


def last_cycle(angle: Float[np.ndarray, "time 4"]) -> tuple[Float[np.ndarray, "100 4"], float]:
    """Returns the last whole cycle at 100 points, and its period over 100 samples.

    A cycle is from one rise of the left hip through its mean to the next; NaN where there is none.
    """
    hip = angle[:, LEFT_HIP] - angle[-3 * NUM_POINTS :, LEFT_HIP].mean()
    before = np.flatnonzero((hip[:-1] < 0) & (hip[1:] >= 0))
    if before.size < 2:
        return np.full((NUM_POINTS, 4), np.nan), float("nan")
    rises = before + hip[before] / (hip[before] - hip[before + 1])
    places = np.linspace(rises[-2], rises[-1], NUM_POINTS + 1)[:-1]
    samples = np.arange(len(angle))
    cycle = np.stack([np.interp(places, samples, joint) for joint in angle.T], axis=1)
    return cycle, float(rises[-1] - rises[-2]) / NUM_POINTS


def _shifted(
    cycle: Float[np.ndarray, "100 4"], human: Float[np.ndarray, "100 4"]
) -> Float[np.ndarray, "100 4"]:
    """Returns a cycle rolled in time to where it fits best."""
    rolled = [np.roll(cycle, shift, axis=0) for shift in range(NUM_POINTS)]
    errors = [np.sum((each - human) ** 2) for each in rolled]
    return rolled[int(np.argmin(errors))]


def _rms(off: Float[np.ndarray, "time 4"]) -> Float[np.ndarray, "4"]:
    return np.sqrt(np.mean(off**2, axis=0))
