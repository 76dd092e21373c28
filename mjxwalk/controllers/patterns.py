"""Pattern generators: networks of Rayleigh oscillators that draw the four angles of two legs.

`FourJoints` is the network of the thesis, one oscillator a joint; `rayleigh` has its equations.

`HarmonicLegs` is ours, since one oscillator a knee leaves out the knee's second harmonic, which is
as large as its first. Each leg has an oscillator for each harmonic h of the stride, all of
amplitude 1, x_h with the rate v_h:

    dv_h/dt = alpha_h (1 - p_h v_h^2) v_h - (h mu)^2 x_h + force_h
    force_1 = k (v_1 - v_1 of the other leg)
    force_h = entrain_h v_1 x_(h-1)

The legs' first oscillators push each other into antiphase as the thesis' do. The product of a rate
with an angle, by which the thesis ties a hip to its knee, carries the sum of their frequencies, so
here each harmonic is driven by the first and the one below it, and locks to them. A joint's angle
is a centre and a weighted sum of the x_h and v_h / (h mu) of its leg.
"""

import dataclasses
from typing import Any, NamedTuple, Protocol, runtime_checkable

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk import gaits
from mjxwalk.controllers import rayleigh
from mjxwalk.controllers.rayleigh import Genes, Motion, Network, Scalar
from mjxwalk.gaits import Gait

MOST_HARMONICS = gaits.NUM_POINTS // 2  # a gait of so many points has no more
RIGHT = np.array([0.0, np.pi, 0.0, np.pi])  # phase of the right joints behind the left, rad


@runtime_checkable
class PatternGenerator(Protocol):
    """What turns a genotype into angles over time, from a start that a gait gives."""

    def template(self) -> Any:
        """Returns a genotype."""
        ...

    def bounds(self) -> tuple[Any, Any]:
        """Returns the lowest and highest genotype that evolution begins with."""
        ...

    def begin(self, genotype: Any, gait: Gait, /) -> tuple[Any, Any]:
        """Returns the network's parameters, and its state at the left heel's strike."""
        ...

    def step(self, network: Any, state: Any, timestep: Scalar, /) -> Any:
        """Returns the state a time step (s) later."""
        ...

    def read(self, network: Any, state: Any, /) -> Motion:
        """Returns angles and rates of left hip, right hip, left knee, right knee."""
        ...

    def kick(self, network: Any, state: Any, factor: float, /) -> Any:
        """Returns the state with the left leg's oscillators nearer to, or farther from, rest."""
        ...

    def table(self, genotype: Any, /) -> list[tuple[str, float]]:
        """Returns the genotype's numbers by name."""
        ...


def angular_frequency(gait: Gait) -> float:
    """Returns that of the stride, rad/s; a gait without time takes as long as adults'."""
    return 2 * np.pi / stride_time(gait)


def stride_time(gait: Gait) -> float:
    """Returns the duration of the cycle, s; a gait without time takes as long as adults'."""
    return gait.stride_time or gaits.ADULT_STRIDE_TIME


@dataclasses.dataclass(frozen=True, kw_only=True)
class FourJoints:
    """The thesis' network: twelve genes; what it leaves open is from the gait.

    Frequencies are the stride's, centres the means of the joints; p gives each joint the amplitude
    of its first harmonic, and the start has the phase of that. Ours: the thesis gives none of them.

    Attributes:
      largest: gene that evolution begins with; the smallest is 0.
    """

    largest: float = 1.0  # MATLAB's default range; the thesis names none

    def __post_init__(self) -> None:
        if not self.largest > 0:
            raise ValueError(f"largest must be positive, got {self.largest}")

    def template(self) -> Genes:
        """Returns the thesis' Table 1."""
        return rayleigh.thesis_genes()

    def bounds(self) -> tuple[float, float]:
        """Returns the lowest and highest gene."""
        return 0.0, self.largest

    def begin(self, genotype: Genes, gait: Gait) -> tuple[Network, Motion]:
        """Returns the network, and its state at the left heel's strike."""
        firsts = [gaits.harmonics(curve, 1) for curve in (gait.hip, gait.knee)]
        each = [firsts[joint] for joint in (0, 0, 1, 1)]
        amplitude = jnp.array([float(first.amplitude[0]) for first in each])
        phase = jnp.array([float(first.phase[0]) for first in each]) + jnp.asarray(RIGHT)
        network = rayleigh.four_joints(
            genotype,
            mu=jnp.full(4, angular_frequency(gait)),
            amplitude=amplitude,
            centre=jnp.array([first.mean for first in each]),
        )
        return network, rayleigh.on_cycle(network, amplitude, phase)

    def step(self, network: Network, state: Motion, timestep: Scalar) -> Motion:
        """Returns the state a time step (s) later."""
        return rayleigh.step(network, state, timestep)

    def read(self, network: Network, state: Motion) -> Motion:
        """Returns the state, which is that of the joints."""
        del network
        return state

    def kick(self, network: Network, state: Motion, factor: float) -> Motion:
        """Returns the state with angles about their centres, and rates, of the left multiplied."""
        factors = jnp.array([factor, 1.0, factor, 1.0])
        angle = network.centre + factors * (state.angle - network.centre)
        return Motion(angle, factors * state.rate)

    def table(self, genotype: Genes) -> list[tuple[str, float]]:
        """Returns the genes by the thesis' names."""
        values = [*np.asarray(genotype.coupling), *np.asarray(genotype.alpha)]
        names = (*rayleigh.COUPLINGS, *rayleigh.ALPHAS)
        return [(name, float(value)) for name, value in zip(names, values, strict=True)]


class HarmonicGenes(NamedTuple):
    """A genotype of `HarmonicLegs`; both legs have the same.

    Attributes:
      tempo: angular frequency over that of the stride.
      alpha: of each harmonic, 1/s.
      across: k, between the legs, 1/s.
      entrain: of harmonics 2 and up, 1/s.
      centre: of hip and knee, degrees.
      cosine: weight of each x_h in hip and knee, degrees.
      sine: weight of each v_h / (h mu), degrees.
    """

    tempo: Float[Array, ""]
    alpha: Float[Array, " harmonic"]
    across: Float[Array, ""]
    entrain: Float[Array, " higher"]
    centre: Float[Array, "2"]
    cosine: Float[Array, "2 harmonic"]
    sine: Float[Array, "2 harmonic"]


class HarmonicNetwork(NamedTuple):
    """The parameters of the equations above, as the genes and a gait make them."""

    genes: HarmonicGenes
    mu: Float[Array, " harmonic"]
    p: Float[Array, " harmonic"]


@dataclasses.dataclass(frozen=True, kw_only=True)
class HarmonicLegs:
    """Our network: an oscillator for each harmonic of the stride in each leg.

    Attributes:
      num_harmonics: oscillators of a leg.
    """

    num_harmonics: int = 3  # ours: with two the knee stays 3.9 degrees off

    def __post_init__(self) -> None:
        if not 2 <= self.num_harmonics <= MOST_HARMONICS:
            raise ValueError(
                f"num_harmonics must be from 2 to {MOST_HARMONICS}, got {self.num_harmonics}"
            )

    def _filled(
        self, tempo: float, alpha: float, across: float, entrain: float, weight: float
    ) -> HarmonicGenes:
        num = self.num_harmonics
        return HarmonicGenes(
            tempo=jnp.asarray(tempo),
            alpha=jnp.full(num, alpha),
            across=jnp.asarray(across),
            entrain=jnp.full(num - 1, entrain),
            centre=jnp.full(2, weight),
            cosine=jnp.full((2, num), weight),
            sine=jnp.full((2, num), weight),
        )

    def template(self) -> HarmonicGenes:
        """Returns a network that swings, and legs that it does not move."""
        return self._filled(tempo=1.0, alpha=1.0, across=1.0, entrain=5.0, weight=0.0)

    def bounds(self) -> tuple[HarmonicGenes, HarmonicGenes]:
        """Returns the lowest and highest genotype; ours: about as far as human joints go."""
        return (
            self._filled(tempo=0.99, alpha=0.5, across=0.3, entrain=2.0, weight=-30.0),
            self._filled(tempo=1.01, alpha=1.0, across=0.6, entrain=10.0, weight=30.0),
        )

    def begin(self, genotype: HarmonicGenes, gait: Gait) -> tuple[HarmonicNetwork, Motion]:
        """Returns the network, and its state with all of the left leg at the peak of a cosine."""
        order = jnp.arange(1.0, self.num_harmonics + 1.0)
        mu = genotype.tempo * angular_frequency(gait) * order
        across = jnp.where(order == 1.0, genotype.across, 0.0)
        p = jnp.asarray(rayleigh.harmonic_balance(genotype.alpha, across, mu, 1.0))
        # Half a stride later, even harmonics are where they were.
        right = jnp.where(order % 2 == 1, -1.0, 1.0)
        angle = jnp.stack([jnp.ones(self.num_harmonics), right])
        return HarmonicNetwork(genotype, mu, p), Motion(angle, jnp.zeros_like(angle))

    def step(self, network: HarmonicNetwork, state: Motion, timestep: Scalar) -> Motion:
        """Returns the state, [leg, harmonic] and without unit, a time step (s) later."""
        return rayleigh.runge_kutta(lambda at: _change(network, at), state, timestep)

    def read(self, network: HarmonicNetwork, state: Motion) -> Motion:
        """Returns angles and rates of the joints."""
        genes = network.genes
        rate = _change(network, state).rate
        waves = (state.angle, state.rate / network.mu), (state.rate, rate / network.mu)
        angle, angle_rate = (
            jnp.sum(genes.cosine[:, None] * x + genes.sine[:, None] * v, axis=2) for x, v in waves
        )
        return Motion((genes.centre[:, None] + angle).reshape(4), angle_rate.reshape(4))

    def kick(self, network: HarmonicNetwork, state: Motion, factor: float) -> Motion:
        """Returns the state with all of the left multiplied."""
        del network
        factors = jnp.array([[factor], [1.0]])
        return Motion(factors * state.angle, factors * state.rate)

    def table(self, genotype: HarmonicGenes) -> list[tuple[str, float]]:
        """Returns the genes by name."""
        rows = [("tempo", float(genotype.tempo)), ("k between the legs", float(genotype.across))]
        for h in range(self.num_harmonics):
            rows.append((f"alpha of harmonic {h + 1}", float(genotype.alpha[h])))
            if h:
                rows.append((f"entrain of harmonic {h + 1}", float(genotype.entrain[h - 1])))
        for joint, name in enumerate(("hip", "knee")):
            rows.append((f"{name} centre", float(genotype.centre[joint])))
            for h in range(self.num_harmonics):
                rows.append((f"{name} cosine {h + 1}", float(genotype.cosine[joint, h])))
                rows.append((f"{name} sine {h + 1}", float(genotype.sine[joint, h])))
        return rows


def _change(network: HarmonicNetwork, state: Motion) -> Motion:
    """Returns the time derivative."""
    genes, (x, v) = network.genes, state
    own = genes.alpha * (1.0 - network.p * v**2) * v - network.mu**2 * x
    across = genes.across * (v[:, :1] - v[::-1, :1])
    higher = genes.entrain * v[:, :1] * x[:, :-1]
    return Motion(v, own + jnp.concatenate([across, higher], axis=1))
