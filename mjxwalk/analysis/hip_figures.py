"""Figures 13 to 16 of Reil & Massey (2001): what the network asks of the hips, and what they do.

"Facilitating controller evolution in morpho-functional machines - a bipedal case study", section 5.
The paper's text calls Figure 16 its Figure 17.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure

from mjxwalk.analysis.figures import COLOURS, FAR, NEAR
from mjxwalk.envs import Anatomy
from mjxwalk.replay import Recording

SETTLED = 4.0  # s; ours: the paper's figures show transients of about that length


class Course(NamedTuple):
    """Hips and knees of one trial, left and right, to the frame in which it ends.

    Attributes:
      time: s.
      desired: hip angles, rad.
      hip: actual ones.
      knee: angles, rad.
    """

    time: Float[np.ndarray, " frame"]
    desired: Float[np.ndarray, "frame 2"]
    hip: Float[np.ndarray, "frame 2"]
    knee: Float[np.ndarray, "frame 2"]

    @property
    def settled(self) -> Any:
        """The frames after the start's transient; all of a trial that ends in it."""
        late = self.time >= SETTLED
        return late if late.any() else ~late


def course(recording: Recording, anatomy: Anatomy, walker: int = 0) -> Course:
    """Returns the course of one recorded walker whose hips are asked for angles."""
    hips, knees = ([getattr(leg, role) for leg in anatomy.legs] for role in ("hip", "knee"))
    last = int(np.argmax(recording.done[:, walker])) or len(recording.time) - 1
    # The state of the start has no desired angles yet.
    frames = slice(1, last + 1)
    states = recording.states
    qpos = np.asarray(states.qpos)[frames, walker]
    return Course(
        time=np.asarray(recording.time)[frames, walker],
        desired=np.asarray(states.own.target)[frames, walker],
        hip=qpos[:, hips],
        knee=qpos[:, knees],
    )


def angles_over_time(shown: Course, seconds: float = 8.0) -> Figure:
    """Returns Figure 13: desired and actual hip angles over time.

    Args:
      shown: from `course`.
      seconds: from the start on.
    """
    figure = Figure(figsize=(9, 4.6), layout="constrained")
    axes: Any = figure.subplots(2, 1, sharex=True, sharey=True)
    frames = shown.time <= seconds
    for leg, (axis, name) in enumerate(zip(axes, ("left", "right"), strict=True)):
        axis.plot(shown.time[frames], shown.desired[frames, leg], color=COLOURS[1], label="desired")
        axis.plot(shown.time[frames], shown.hip[frames, leg], color=NEAR, label="actual")
        axis.set_ylabel(f"{name} hip (rad)")
    place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}
    axes[0].legend(frameon=False, fontsize=8, ncols=2, **place)
    axes[1].set_xlabel("time (s)")
    return figure


def locking(shown: Course) -> Figure:
    """Returns Figure 14: the left hip over the left output; thick once it has settled."""
    names = "desired left hip angle (rad)", "actual left hip angle (rad)"
    return _one_cycle(shown, shown.desired[:, 0], shown.hip[:, 0], names)


def attractors(shown: Course) -> Figure:
    """Returns Figure 15: right over left hip, desired and actual; thick once they have settled."""
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    axes: Any = figure.subplots(1, 2)
    for axis, name, angle in zip(
        axes, ("desired", "actual"), (shown.desired, shown.hip), strict=True
    ):
        _cycle(axis, shown, angle[:, 0], angle[:, 1])
        axis.set_title(name, fontsize=10)
        axis.set(xlabel="left hip angle (rad)", ylabel="right hip angle (rad)")
    return figure


def limit_cycle(shown: Course) -> Figure:
    """Returns Figure 16: the left knee over the left hip; thick once they have settled."""
    names = "left hip angle (rad)", "left knee angle (rad)"
    return _one_cycle(shown, shown.hip[:, 0], shown.knee[:, 0], names)


def _one_cycle(shown: Course, x: Any, y: Any, names: tuple[str, str]) -> Figure:
    """Returns a figure of one angle over another, whose axes have these names."""
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    axis: Any = figure.subplots()
    _cycle(axis, shown, x, y)
    axis.set(xlabel=names[0], ylabel=names[1])
    return figure


def _cycle(axis: Any, shown: Course, x: Any, y: Any) -> None:
    """Draws one angle over another, all of it thin and what has settled above it."""
    settled = shown.settled
    axis.set_box_aspect(0.9)
    axis.plot(x, y, color=FAR, linewidth=0.7)
    axis.plot(x[settled], y[settled], color=NEAR, linewidth=1.2)
