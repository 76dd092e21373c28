"""The thesis' figures of Rayleigh oscillators, from its settings and from ours.

"Designing CPG for Biped Locomotion Control using Nonlinear Dynamical Theory", Indian Institute of
Information Technology, Allahabad: Figures 2.4 to 2.8 of one oscillator, 5.1 to 5.6 of four.
"""

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure

from mjxwalk.analysis.figures import COLOURS, FAR, NEAR
from mjxwalk.analysis.fits import Fit, Kicked
from mjxwalk.controllers import rayleigh
from mjxwalk.controllers.rayleigh import JOINTS, Motion
from mjxwalk.gaits import NUM_POINTS

TIMESTEP = 0.01  # s; ours
JOINT_STYLES = dict(
    zip(
        JOINTS,
        ({"color": c, "linestyle": s} for c in (NEAR, COLOURS[1]) for s in ("-", "--")),
        strict=True,
    )
)


class Demonstration(NamedTuple):
    """One oscillator of section 2.6, and what its figure is to show."""

    number: str
    alpha: float
    p: float
    mu: float
    shows: str


DEMONSTRATIONS = (
    Demonstration("2.4", 1.0, 5.0, 0.5, "angle over time"),
    Demonstration("2.5", 1.0, 5.0, 0.5, "its limit cycle"),
    Demonstration("2.6", 1.0, 50.0, 0.5, "a larger p lowers the amplitude"),
    Demonstration("2.7", 1.0, 5.0, 1.0, "a larger mu raises the frequency"),
    Demonstration("2.8", 1.0, 1.0, 0.2, "the equation with a centre"),
)
DEMONSTRATED_S = 100.0  # ours: the thesis' axes are lost


def demonstrate(shown: Demonstration) -> Motion:
    """Returns the motion of one oscillator from 0.1 at rest, in the thesis' arbitrary unit."""
    network = rayleigh.alone(alpha=shown.alpha, p=shown.p, mu=shown.mu)
    start = Motion(jnp.array([0.1]), jnp.zeros(1))
    return rayleigh.simulate(
        network, start, timestep=TIMESTEP, num_steps=round(DEMONSTRATED_S / TIMESTEP)
    )


def one_oscillator() -> Figure:
    """Returns Figures 2.4 to 2.8: what p and mu do to one oscillator."""
    figure = Figure(figsize=(9, 6), layout="constrained")
    axes: Any = figure.subplots(2, 3).ravel()
    for axis, shown in zip(axes, DEMONSTRATIONS, strict=False):
        angle, rate = (np.asarray(part)[:, 0] for part in demonstrate(shown))
        if shown.number == "2.5":
            axis.plot(angle, rate, color=NEAR, linewidth=0.9)
            axis.set(xlabel="a", ylabel="da/dt (1/s)")
        else:
            axis.plot(TIMESTEP * np.arange(len(angle)), angle, color=NEAR, linewidth=0.9)
            axis.set(xlabel="time (s)", ylabel="a")
        values = f"α = {shown.alpha:g}, p = {shown.p:g}, μ = {shown.mu:g}"
        axis.set_title(f"{shown.number}: {shown.shows}\n{values}", fontsize=9)
    axes[-1].axis("off")
    return figure


def angles_over_time(fit: Fit, cycle_s: float, seconds: float = 5.0) -> Figure:
    """Returns Figure 5.1: the four angles over time, with the human's dotted.

    Args:
      fit: from `fits.measure`.
      cycle_s: duration of the human's cycle, s.
      seconds: shown.
    """
    figure = Figure(figsize=(9, 5), layout="constrained")
    axes: Any = figure.subplots(2, 1, sharex=True)
    time, shown = _times(fit.angle, cycle_s, seconds)
    human = fit.human[np.arange(len(time)) % NUM_POINTS]
    for place, name in enumerate(JOINTS):
        axis = axes[place // 2]
        axis.plot(time, fit.angle[shown, place], label=name, linewidth=1.3, **JOINT_STYLES[name])
        axis.plot(time, human[:, place], color="0.6", linestyle=":", linewidth=1.0)
    for axis in axes:
        axis.set_ylabel("angle (°)")
        axis.legend(loc="upper right", frameon=False, fontsize=8)
    axes[1].set_xlabel("time (s); dotted: human")
    return figure


def limit_cycles(fit: Fit, cycle_s: float) -> Figure:
    """Returns Figures 5.2 to 5.5: rate over angle of each joint, with the human's dotted."""
    figure = Figure(figsize=(9, 7), layout="constrained")
    axes: Any = figure.subplots(2, 2).ravel()
    # By differences, as the human's rate is not measured.
    human_rate = np.gradient(np.concatenate([fit.human[-1:], fit.human, fit.human[:1]]), axis=0)
    human_rate = human_rate[1:-1] * NUM_POINTS / cycle_s
    for axis, place, number in zip(axes, (2, 3, 0, 1), ("5.2", "5.3", "5.4", "5.5"), strict=True):
        axis.plot(_closed(fit.human[:, place]), _closed(human_rate[:, place]), color="0.6", ls=":")
        axis.plot(fit.angle[:, place], fit.rate[:, place], color=NEAR, linewidth=0.9)
        axis.set_title(f"{number}: {JOINTS[place]}", fontsize=10)
        axis.set(xlabel="angle (°)", ylabel="angular velocity (°/s)")
    return figure


def rates_over_time(fit: Fit, cycle_s: float, seconds: float = 5.0) -> Figure:
    """Returns Figure 5.6: the four angular velocities over time."""
    figure = Figure(figsize=(9, 3.5), layout="constrained")
    axis: Any = figure.subplots()
    time, shown = _times(fit.rate, cycle_s, seconds)
    for place, name in enumerate(JOINTS):
        axis.plot(time, fit.rate[shown, place], label=name, linewidth=1.1, **JOINT_STYLES[name])
    axis.set(xlabel="time (s)", ylabel="angular velocity (°/s)")
    axis.legend(loc="upper right", frameon=False, fontsize=8, ncols=4)
    return figure


def kicked(course: Kicked) -> Figure:
    """Returns the phase portraits of a left hip and knee that were kicked off their cycle."""
    figure = Figure(figsize=(9, 4), layout="constrained")
    axes: Any = figure.subplots(1, 2)
    for axis, place in zip(axes, (0, 2), strict=True):
        axis.plot(course.angle[:, place], course.rate[:, place], color=FAR, linewidth=0.8)
        axis.plot(course.cycle[:, place], course.cycle_rate[:, place], color=NEAR, linewidth=1.8)
        axis.plot(course.angle[0, place], course.rate[0, place], "o", color=COLOURS[1])
        axis.set_title(JOINTS[place], fontsize=10)
        axis.set(xlabel="angle (°)", ylabel="angular velocity (°/s)")
    return figure


def error_over_generations(errors: Float[np.ndarray, " generation"], unit: str) -> Figure:
    """Returns the error of the fittest of each generation."""
    figure = Figure(figsize=(9, 3), layout="constrained")
    axis: Any = figure.subplots()
    axis.plot(1 + np.arange(len(errors)), errors, color=NEAR, linewidth=1.2)
    axis.set(xlabel="generation", ylabel=f"error of the fittest ({unit})", ylim=(0, None))
    return figure


def _times(
    values: Float[np.ndarray, "time 4"], cycle_s: float, seconds: float
) -> tuple[Float[np.ndarray, " shown"], slice]:
    """Returns the times of what is shown, s, and where it is."""
    num = min(len(values), round(seconds / cycle_s * NUM_POINTS))
    return cycle_s / NUM_POINTS * np.arange(num), slice(num)


def _closed(values: Float[np.ndarray, " point"]) -> Float[np.ndarray, " more"]:
    return np.append(values, values[:1])
