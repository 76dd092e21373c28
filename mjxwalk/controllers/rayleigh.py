"""Rayleigh oscillators, alone and coupled, as a generator of the joint angles of walking.

A thesis of the Indian Institute of Information Technology, Allahabad, "Designing CPG for Biped
Locomotion Control using Nonlinear Dynamical Theory", equations 4 and 13 to 16; the coupling is
after de Pina Filho, Dutra & Raptopoulos, "Modelling of bipedal robots using coupled nonlinear
oscillators". Every oscillator i is one joint, with the angle a and the rate v:

    dv_i/dt = alpha_i (1 - p_i v_i^2) v_i - mu_i^2 (a_i - c_i)
              + sum_j same_ij (v_i - v_j) + sum_j product_ij v_j (a_j - c_j)

`same` pushes a pair apart where it is positive, into antiphase; `product` runs at twice the
frequency of oscillator j. All formulas hold in any unit of angle, but p (s^2/angle^2) and
`product` (1/(angle s)) are numbers of one unit: here degrees, as in the thesis.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

JOINTS = ("left hip", "right hip", "left knee", "right knee")
LEFT_HIP, RIGHT_HIP, LEFT_KNEE, RIGHT_KNEE = range(4)
COUPLINGS = ("k12", "k13", "k21", "k24", "k31", "k34", "k42", "k43")
ALPHAS = ("alpha1", "alpha2", "alpha3", "alpha4")

Scalar = float | int | Float[Array, "*shape"] | Float[np.ndarray, "*shape"]
StateT = TypeVar("StateT")


class Motion(NamedTuple):
    """Where oscillators are.

    Attributes:
      angle: degrees.
      rate: degrees/s.
    """

    angle: Float[Array, "*time oscillator"]
    rate: Float[Array, "*time oscillator"]


class Network(NamedTuple):
    """Rayleigh oscillators and how they are coupled; [i, j] is the effect of j on i.

    Attributes:
      alpha: how fast energy comes in and goes out, 1/s.
      p: sets the amplitude, s^2/degree^2.
      mu: angular frequency, rad/s.
      centre: degrees.
      same: coupling of equal frequencies, 1/s; only its difference from zero off the diagonal
        counts.
      product: coupling of a frequency with its double, 1/(degree s).
    """

    alpha: Float[Array, " oscillator"]
    p: Float[Array, " oscillator"]
    mu: Float[Array, " oscillator"]
    centre: Float[Array, " oscillator"]
    same: Float[Array, "oscillator oscillator"]
    product: Float[Array, "oscillator oscillator"]


class Genes(NamedTuple):
    """What the thesis evolves: twelve numbers in the order of its chromosome.

    Attributes:
      coupling: k12, k13, k21, k24, k31, k34, k42 and k43; 1 and 2 are the left and right hip, 3 and
        4 the left and right knee.
      alpha: of the four, 1/s.
    """

    coupling: Float[Array, "8"]
    alpha: Float[Array, "4"]


# Table 1 of the thesis.
THESIS_COUPLING = (0.2010, 0.0125, 0.2010, 0.0129, 0.0125, 0.3012, 0.0129, 0.3012)
THESIS_ALPHA = (0.0014, 0.0020, 0.0108, 0.0108)


def thesis_genes() -> Genes:
    """Returns Table 1 of the thesis: all that it tells of its network."""
    return Genes(jnp.array(THESIS_COUPLING), jnp.array(THESIS_ALPHA))


def harmonic_balance(alpha: Scalar, coupling: Scalar, mu: Scalar, amplitude: Scalar) -> Scalar:
    """Returns the p with which an oscillator, or each of an antiphase pair, has an amplitude.

    With a = A cos(mu t) the terms in phase with the rate have to cancel over a cycle. In antiphase
    the coupling k (v_i - v_j) is 2 k v_i, and the mean of v^4 is three quarters of the mean of v^2
    times the square of the rate's amplitude V = mu A, so alpha + 2 k = 3/4 alpha p V^2, or

        p = 4 (alpha + 2 k) / (3 alpha mu^2 A^2).

    The frequency stays mu. Ours: the thesis gives neither p nor how it was found.

    Args:
      alpha: of the oscillator, 1/s.
      coupling: k of the pair, 1/s; 0 for one alone.
      mu: angular frequency, rad/s.
      amplitude: A, degrees.
    """
    return 4.0 * (alpha + 2.0 * coupling) / (3.0 * alpha * mu**2 * amplitude**2)


def harmonic_amplitude(alpha: Scalar, coupling: Scalar, mu: Scalar, p: Scalar) -> Scalar:
    """Returns the amplitude that a p gives, degrees: `harmonic_balance` the other way round."""
    return (4.0 * (alpha + 2.0 * coupling) / (3.0 * alpha * p * mu**2)) ** 0.5


def four_joints(
    genes: Genes,
    *,
    mu: Float[Array, "4"],
    amplitude: Float[Array, "4"],
    centre: Float[Array, "4"],
) -> Network:
    """Returns the network of equations 13 to 16.

    Args:
      genes: to become couplings and alphas.
      mu: angular frequency of each joint, rad/s.
      amplitude: that p is chosen for, by harmonic balance with the left-right coupling, degrees.
      centre: of each joint, degrees.
    """
    k12, k13, k21, k24, k31, k34, k42, k43 = genes.coupling
    zero = jnp.zeros(())
    across = jnp.stack([k12, k21, k34, k43])
    same = [[zero, k12, zero, zero], [k21, zero, zero, zero]]
    same += [[zero, zero, zero, k34], [zero, zero, k43, zero]]
    product = [[zero, zero, k13, zero], [zero, zero, zero, k24]]
    product += [[k31, zero, zero, zero], [zero, k42, zero, zero]]
    return Network(
        alpha=genes.alpha,
        p=jnp.asarray(harmonic_balance(genes.alpha, across, mu, amplitude)),
        mu=mu,
        centre=centre,
        same=jnp.stack([jnp.stack(row) for row in same]),
        product=jnp.stack([jnp.stack(row) for row in product]),
    )


def alone(*, alpha: float, p: float, mu: float, centre: float = 0.0) -> Network:
    """Returns one oscillator without coupling, equation 4."""
    one = [jnp.array([value], float) for value in (alpha, p, mu, centre)]
    return Network(*one, same=jnp.zeros((1, 1)), product=jnp.zeros((1, 1)))


def change(network: Network, motion: Motion) -> Motion:
    """Returns the time derivative: rates (degrees/s) and accelerations (degrees/s^2)."""
    off, rate = motion.angle - network.centre, motion.rate
    own = network.alpha * (1.0 - network.p * rate**2) * rate - network.mu**2 * off
    apart = jnp.sum(network.same * (rate[:, None] - rate[None, :]), axis=1)
    double = jnp.sum(network.product * (rate * off)[None, :], axis=1)
    return Motion(rate, own + apart + double)


def runge_kutta(derivative: Callable[[StateT], StateT], state: StateT, timestep: Scalar) -> StateT:
    """Returns a pytree one step of the classical Runge-Kutta method of fourth order later."""

    def moved(by: Scalar, slope: StateT) -> StateT:
        return jax.tree.map(lambda x, d: x + by * d, state, slope)

    first = derivative(state)
    second = derivative(moved(timestep / 2.0, first))
    third = derivative(moved(timestep / 2.0, second))
    fourth = derivative(moved(timestep, third))
    return jax.tree.map(
        lambda x, a, b, c, d: x + timestep / 6.0 * (a + 2.0 * b + 2.0 * c + d),
        state,
        first,
        second,
        third,
        fourth,
    )


def step(network: Network, motion: Motion, timestep: Scalar) -> Motion:
    """Returns the oscillators a time step (s) later."""
    return runge_kutta(lambda at: change(network, at), motion, timestep)


def simulate(network: Network, start: Motion, *, timestep: Scalar, num_steps: int) -> Motion:
    """Returns the motion at every step, the start first: [num_steps + 1, oscillator]."""

    def one(motion: Motion, _: None) -> tuple[Motion, Motion]:
        after = step(network, motion, timestep)
        return after, after

    _, rest = jax.lax.scan(one, start, length=num_steps)
    return Motion(*(jnp.concatenate([a[None], b]) for a, b in zip(start, rest, strict=True)))


def on_cycle(
    network: Network, amplitude: Float[Array, " oscillator"], phase: Float[Array, " oscillator"]
) -> Motion:
    """Returns the motion on the cycle of harmonic balance.

    Args:
      network: its centres and frequencies.
      amplitude: degrees.
      phase: of the cosine, rad.
    """
    return Motion(
        angle=network.centre + amplitude * jnp.cos(phase),
        rate=-network.mu * amplitude * jnp.sin(phase),
    )
