"""A recurrent network for any body: senses and a clock, units that remember, a number a motor."""

import dataclasses
import math
from typing import Any, Literal, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.controllers import clock
from mjxwalk.controllers.controller import Description
from mjxwalk.controllers.policy import Policy
from mjxwalk.controllers.wiring import Connection, Wiring, ends, units
from mjxwalk.envs.checks import count

GATES = {"elman": 1, "gru": 3}  # sums a unit
MOST_UNITS = 4096
OWN_KEY = 0  # of the first weights, which are the same for every run; ours


class RecurrentWeights(NamedTuple):
    """A genotype; of a GRU the rows are those of the reset gate, the update gate and the candidate.

    Attributes:
      inputs: from senses and clock to units.
      units: from units, as they were, to units.
      bias: of the units.
      outputs: from units to motors.
      direct: from senses and clock to motors.
      centre: of each motor.
      pace: gene of the clock's frequency.
    """

    inputs: Float[Array, "gate_unit input"]
    units: Float[Array, "gate_unit unit"]
    bias: Float[Array, " gate_unit"]
    outputs: Float[Array, "row unit"]
    direct: Float[Array, "row input"]
    centre: Float[Array, " row"]
    pace: Float[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class RecurrentNetwork(Policy):
    """Units that remember, beside a linear policy, at first silent; each side has its own memory.

    Attributes:
      cell: "elman" for tanh of a weighted sum (Elman 1990), "gru" for gated units (Cho et al.
        2014), whose reset gate acts on the units before their weights.
      units: a side.
    """

    cell: Literal["elman", "gru"] = "gru"
    units: int = 16

    def __post_init__(self) -> None:
        if self.cell not in GATES:
            raise ValueError(f'cell must be "elman" or "gru", got "{self.cell}"')
        count(self, "units")
        if self.units > MOST_UNITS:
            raise ValueError(f"units must be at most {MOST_UNITS:,}, got {self.units}")
        super().__post_init__()

    def weights(self) -> RecurrentWeights:
        """Returns a walker that lifts its legs in turn; its units drive nothing."""
        num_seen, rows = clock.num_inputs(self), len(self.rows)
        sums = GATES[self.cell] * self.units
        of_inputs, of_units = jax.random.split(jax.random.key(OWN_KEY))
        return RecurrentWeights(
            inputs=jax.random.normal(of_inputs, (sums, num_seen)) / math.sqrt(num_seen),
            units=jax.random.normal(of_units, (sums, self.units)) / math.sqrt(self.units),
            bias=jnp.zeros(sums),
            outputs=jnp.zeros((rows, self.units)),
            direct=clock.lifting(self),
            centre=jnp.zeros(rows),
            pace=jnp.zeros(()),
        )

    def wiring(self) -> Wiring:
        """Returns the units, which read the senses and each other, and the motors, which read both;
        a link of a gated unit has a weight for each gate.
        """
        senses, motors = ends(self.describe())
        gates = ("",) if self.cell == "elman" else ("reset", "update", "candidate")
        return Wiring(
            (senses, units("units", "unit", self.units), motors),
            (
                Connection("inputs", "senses", "units", gates),
                Connection("units", "units", "units", gates),
                Connection("outputs", "units", "motors"),
                Connection("direct", "senses", "motors"),
            ),
            {"bias": "units"},
        )

    def describe(self) -> Description:
        """Returns the columns of the first and of the direct weights, and the last rows."""
        return clock.described(self, super().describe())

    def recall(self, genotype: Any, /) -> Float[Array, "side unit"]:
        """Returns units that remember nothing."""
        del genotype
        return jnp.zeros((self.layout.sides, self.units))

    def respond(
        self,
        genotype: RecurrentWeights,
        memory: Float[Array, "side unit"],
        seen: Float[Array, "side input"],
        phase: Float[Array, " side"],
        /,
    ) -> tuple[Float[Array, "side unit"], Float[Array, "side row"]]:
        """Returns the units one action later, and what they and the direct weights ask for."""
        seen = clock.inputs(self, seen, phase)
        given = seen @ genotype.inputs.T + genotype.bias
        if self.cell == "elman":
            state = jnp.tanh(given + memory @ genotype.units.T)
        else:
            state = self._gated(genotype, memory, given)
        return state, state @ genotype.outputs.T + seen @ genotype.direct.T + genotype.centre

    def _gated(
        self,
        genotype: RecurrentWeights,
        memory: Float[Array, "side unit"],
        given: Float[Array, "side gate_unit"],
    ) -> Float[Array, "side unit"]:
        """Returns a GRU's units one action later; `given` is what senses and biases bring."""
        num = self.units
        gates = jax.nn.sigmoid(given[:, : 2 * num] + memory @ genotype.units[: 2 * num].T)
        reset, update = gates[:, :num], gates[:, num:]
        candidate = jnp.tanh(given[:, 2 * num :] + (reset * memory) @ genotype.units[2 * num :].T)
        return update * memory + (1.0 - update) * candidate
