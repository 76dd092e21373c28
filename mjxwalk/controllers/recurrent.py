"""A pattern generator for any body: one CTRNN a side, coupled across, that drives each motor.

Beer (1995), equation 1, as `mjxwalk.controllers.ctrnn` has it; senses come in from outside, so that
a generator may be without them or feel everything. Both sides have the same weights.
"""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.controllers import sparse
from mjxwalk.controllers.policy import PACE, Policy
from mjxwalk.controllers.wiring import Connection, Wiring, ends, units
from mjxwalk.envs.checks import count, not_negative

STEPS = 3  # of Euler's method from one action to the next; ours: fewer change the period
# ours: two neurons that oscillate, after Beer (1995), section 4, and the weight by which those of
# the other side hold the first one back, so that sides take turns.
OSCILLATOR = np.array([[4.5, 1.0], [-1.0, 4.5]], np.float32)
BIAS = np.array([-2.75, -1.75], np.float32)
CROSSED = -0.5
OSCILLATION = 39.2  # period of that, in time constants; measured
LOWEST, HIGHEST = 0.13, 0.79  # output of the first neuron over a period; measured
START = np.array([[3.4, 1.4], [0.7, 1.4]], np.float32)  # of both sides' first neurons; ours


class Generator(NamedTuple):
    """A genotype.

    Attributes:
      weights: from neurons of the same side [to, from].
      crossed: from neurons of the other side.
      bias: of each neuron.
      slowness: logarithm of each neuron's time constant over the usual one.
      senses: from senses to neurons.
      motors: from neurons' outputs to motors.
      centre: of each motor.
    """

    weights: Float[Array, "neuron neuron"]
    crossed: Float[Array, "neuron neuron"]
    bias: Float[Array, " neuron"]
    slowness: Float[Array, " neuron"]
    senses: Float[Array, "neuron input"]
    motors: Float[Array, "row neuron"]
    centre: Float[Array, " row"]


@dataclasses.dataclass(frozen=True, kw_only=True)
class PatternGenerator(Policy):
    """A CTRNN of some neurons a side.

    Attributes:
      neurons: a side; two of them oscillate from the start.
      feels: whether senses reach the neurons.
      density: share of the links that are there of all from senses to neurons, between neurons of
        a side, and across; those by which two of them oscillate always are.
      wiring_seed: of the choice of these links.
    """

    neurons: int = 6
    feels: bool = True
    density: float = 1.0
    wiring_seed: int = 0

    def __post_init__(self) -> None:
        count(self, "neurons")
        not_negative(self, "wiring_seed")
        if not 0 < self.density <= 1:
            raise ValueError(f"density must be above 0 and at most 1, got {self.density}")
        if self.neurons < 2:
            raise ValueError(f"neurons must be 2 at least, which oscillate, got {self.neurons}")
        super().__post_init__()

    def weights(self) -> Generator:
        """Returns a walker that lifts its legs in turn and feels nothing."""
        num, rows = self.neurons, len(self.rows)
        weights, crossed = np.zeros((2, num, num), np.float32)
        weights[:2, :2] = OSCILLATOR
        crossed[0, 0] = CROSSED if self.layout.sides == 2 else 0.0
        bias = np.zeros(num, np.float32)
        bias[:2] = BIAS
        motors = np.zeros((rows, num), np.float32)
        motors[:, 0] = np.array(self.lift) / (HIGHEST - LOWEST)
        centre = -LOWEST * motors[:, 0]
        parts = (weights, crossed, bias, np.zeros(num), np.zeros((num, len(self.layout.inputs))))
        made = [jnp.asarray(part, jnp.float32) for part in (*parts, motors, centre)]
        return Generator(*made)

    def present(self) -> Generator:
        """Returns which weights are there: of senses if it feels, and across between sides."""
        every = super().present()
        num = self.neurons
        kept = np.zeros((3, num, max(num, len(self.layout.inputs))), bool)
        kept[0, :2, :2] = kept[1, 0, 0] = True  # of the oscillator
        of = {"weights": num, "crossed": num, "senses": len(self.layout.inputs)}
        links = {
            leaf: sparse.drawn(self.density, self.wiring_seed, number, kept[number, :, :columns])
            for number, (leaf, columns) in enumerate(of.items())
        }
        there = {"weights": True, "crossed": self.layout.sides == 2, "senses": self.feels}
        return every._replace(**{leaf: jnp.asarray(links[leaf] & there[leaf]) for leaf in links})

    def wiring(self) -> Wiring:
        """Returns the neurons, which read the senses, each other and those of the other side, and
        the motors, which read the neurons.
        """
        senses, motors = ends(self.describe())
        other = "neurons of the other side"
        num = self.neurons
        layers = units(other, "neuron", num), units("neurons", "neuron", num)
        return Wiring(
            (senses, *layers, motors),
            (
                Connection("senses", "senses", "neurons"),
                Connection("crossed", other, "neurons"),
                Connection("weights", "neurons", "neurons"),
                Connection("motors", "neurons", "motors"),
            ),
            {"bias": "neurons", "slowness": "neurons"},
        )

    def recall(self, genotype: Any, /) -> Float[Array, "side neuron"]:
        """Returns the neurons' states at the start, sides half a period apart."""
        del genotype
        sides = self.layout.sides
        return jnp.zeros((sides, self.neurons)).at[:, :2].set(START[:sides])

    def respond(
        self,
        genotype: Generator,
        memory: Float[Array, "side neuron"],
        seen: Float[Array, "side input"],
        phase: Float[Array, " side"],
        /,
    ) -> tuple[Float[Array, "side neuron"], Float[Array, "side row"]]:
        """Returns the neurons' states one action later, and what they ask for."""
        del phase
        usual = self.layout.time / (PACE * OSCILLATION)
        share = self.period / STEPS / usual * jnp.exp(-genotype.slowness)
        given = seen @ genotype.senses.T if self.feels else jnp.zeros(())
        state = memory
        for _ in range(STEPS):
            out = jax.nn.sigmoid(state + genotype.bias)
            coming = out @ genotype.weights.T + out[::-1] @ genotype.crossed.T + given
            state = state + jnp.minimum(share, 1.0) * (coming - state)
        out = jax.nn.sigmoid(state + genotype.bias)
        return state, out @ genotype.motors.T + genotype.centre
