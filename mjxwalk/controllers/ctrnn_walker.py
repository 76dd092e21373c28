"""A pattern generator of recurrent networks that drives the hips of a biped.

Reil & Massey (2001), sections 3.2 and 4.3; the network is in `ctrnn.py`. Sixty genes make all of
it: 36 weights, 6 biases and 6 time constants of the oscillator that all four are, 6 lateral and 6
sagittal weights. The first neuron of either oscillator of the first pair is a motor neuron: its
output is the desired angle of the hip on its side. Senses are ours; the paper has none.
"""

import dataclasses
import math
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.controllers import ctrnn
from mjxwalk.controllers.controller import Controller
from mjxwalk.envs import HipTargets, SpatialObservation
from mjxwalk.envs.checks import not_negative, positive
from mjxwalk.envs.edge import takes_genotype

# ours, both: legs can only part if their oscillators start apart.
FIRST_PAIR = 1.0  # state of the left neurons of the first pair; the right ones have minus that
SECOND_PAIR = 0.5  # likewise of the second pair
# ours: bring the senses to about -1 ... 1.
PITCH_SCALE = 0.2  # rad
PITCH_RATE_SCALE = 1.0  # rad/s


class Genes(NamedTuple):
    """A genotype; every gene counts from -1 to 1, and `CtrnnWalker` says what it stands for.

    Attributes:
      weight: [i, j] from neuron j to neuron i of each oscillator.
      bias: of the neurons.
      time_constant: of the neurons.
      lateral: from each neuron to its twin on the other side.
      sagittal: from each neuron of the second pair to its twin of the first.
      sense: weight of each sense for each neuron of the first pair: pitch and its rate, the same
        for both sides; contact of the own foot, and of the other.
    """

    weight: Float[Array, "6 6"]
    bias: Float[Array, "6"]
    time_constant: Float[Array, "6"]
    lateral: Float[Array, "6"]
    sagittal: Float[Array, "6"]
    sense: Float[Array, "4 6"]


class Memory(NamedTuple):
    """What the network carries from step to step.

    Attributes:
      state: of every neuron, [oscillator, neuron].
      time: when, s.
    """

    state: Float[Array, "4 6"]
    time: Float[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class CtrnnWalker(Controller):
    """What the genes stand for; the paper's ranges are in a thesis that is lost, so all are ours.

    Attributes:
      weight: largest, either way.
      bias: likewise; counted from where half of what a neuron receives at most is its threshold,
        which makes most networks oscillate.
      fastest: smallest time constant, s.
      slowest: largest, s; between them genes count logarithmically.
      lateral: largest lateral weight, either way.
      sagittal: largest sagittal weight, either way.
      sense: largest weight of a sense, either way; 0 leaves the network without senses.
      swing: difference of the desired hip angles of outputs 1 and 0, rad.
      forward: desired hip angle of an output of a half, rad.
    """

    weight: float = 16.0
    bias: float = 2.0
    fastest: float = 0.05
    slowest: float = 0.5
    lateral: float = 8.0
    sagittal: float = 8.0
    sense: float = 0.0
    swing: float = 0.84
    forward: float = 1.065

    def __post_init__(self) -> None:
        positive(self, "weight", "bias", "fastest", "slowest", "lateral", "sagittal", "swing")
        not_negative(self, "sense")
        if self.slowest < self.fastest:
            raise ValueError(f"slowest must be at least fastest, got {self.slowest}")

    def template(self) -> Genes:
        """Returns zeros."""
        six = jnp.zeros(ctrnn.NUM_NEURONS)
        return Genes(jnp.zeros((6, 6)), six, six, six, six, jnp.zeros((4, 6)))

    def mask(self) -> Genes:
        """Returns which genes are there."""
        there = super().mask()
        return there if self.sense else there._replace(sense=jnp.zeros((4, 6), bool))

    def network(self, genes: Genes) -> ctrnn.Coupled:
        """Returns the network that the genes stand for."""
        weight = self.weight * genes.weight
        lateral, sagittal = self.lateral * genes.lateral, self.sagittal * genes.sagittal
        # Beer (1995) calls a network centre-crossing where a bias is minus half of the sum of the
        # incoming weights; the sagittal one counts half, as only the first pair receives it.
        centre = -0.5 * (weight.sum(axis=1) + lateral + 0.5 * sagittal)
        middle = 0.5 * (math.log(self.fastest) + math.log(self.slowest))
        reach = 0.5 * (math.log(self.slowest) - math.log(self.fastest))
        time_constant = jnp.exp(middle + reach * genes.time_constant)
        oscillator = ctrnn.Network(weight, centre + self.bias * genes.bias, time_constant)
        return ctrnn.Coupled(oscillator, lateral, sagittal)

    @takes_genotype
    def init(self, genes: Genes) -> Memory:
        """Returns the network at the start of a trial: left and right are each other's opposite."""
        del genes
        sides = jnp.array([FIRST_PAIR, -FIRST_PAIR, SECOND_PAIR, -SECOND_PAIR])
        state = jnp.broadcast_to(sides[:, None], (ctrnn.NUM_OSCILLATORS, ctrnn.NUM_NEURONS))
        return Memory(state, jnp.zeros(()))

    @takes_genotype
    def act(
        self, genes: Genes, memory: Memory, observation: SpatialObservation
    ) -> tuple[Memory, HipTargets]:
        """Returns the network at the time of the observation, and the hips' desired angles."""
        network = self.network(genes)
        given = jnp.zeros((4, 6))
        if self.sense:
            felt = self.sense * self._sensed(genes, observation)
            given = jnp.concatenate([felt, given[2:]])
        elapsed = observation.time - memory.time
        state = ctrnn.coupled_step(network, memory.state, given, elapsed)
        motor = jax.nn.sigmoid(state[:2, 0] + network.oscillator.bias[0])
        return Memory(state, observation.time), HipTargets(
            self.forward + self.swing * (motor - 0.5)
        )

    def weight_table(self, genotype: Genes) -> list[tuple[str, str, str, float]]:
        """Returns what the genes stand for as rows of kind, neuron, source and value."""
        network = self.network(genotype)
        rows = [
            ("weight", str(i), str(j), float(value))
            for (i, j), value in np.ndenumerate(np.asarray(network.oscillator.weight))
        ]
        for kind, values in (
            ("bias", network.oscillator.bias),
            ("time constant", network.oscillator.time_constant),
            ("lateral", network.lateral),
            ("sagittal", network.sagittal),
        ):
            rows += [(kind, str(i), "", float(v)) for i, v in enumerate(np.asarray(values))]
        if self.sense:
            names = ("pitch", "pitch rate", "own foot", "other foot")
            for (sense, i), value in np.ndenumerate(np.asarray(genotype.sense)):
                rows.append(("sense", str(i), names[sense], float(self.sense * value)))
        return rows

    def _sensed(self, genes: Genes, observation: SpatialObservation) -> Float[Array, "2 6"]:
        """Returns what the senses give to the neurons of the first pair, left and right."""
        pitch = observation.torso[1] / PITCH_SCALE
        rate = observation.torso_rate[1] / PITCH_RATE_SCALE
        upright = pitch * genes.sense[0] + rate * genes.sense[1]
        # A foot on the ground counts 1, one in the air -1.
        feet = 2.0 * observation.contact.astype(jnp.float32) - 1.0
        own, other = feet[:, None], feet[::-1][:, None]
        return upright + own * genes.sense[2] + other * genes.sense[3]
