"""Continuous-time recurrent neural networks, and a pattern generator made of four of them.

Beer (1995), "On the dynamics of small continuous-time recurrent neural networks", Adaptive Behavior
3(4), equation 1. Neuron i has the state y_i, without unit, the time constant tau_i (s) and the bias
b_i; w_ij is the weight of the synapse from neuron j to neuron i, and I_i what comes from outside:

    tau_i dy_i/dt = -y_i + sum_j w_ij s(y_j + b_j) + I_i,     s(x) = 1 / (1 + exp(-x))

A neuron's output is s(y_i + b_i), between 0 and 1. Time is stepped by Euler's explicit method.

The pattern generator is that of Reil & Massey (2001), "Facilitating controller evolution in
morpho-functional machines - a bipedal case study", section 4.3, after the coupled cells of
Golubitsky, Stewart, Buono & Collins (1999), "Symmetry in locomotor central pattern generators and
animal gaits", Nature 401: two cells for each leg, all alike.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

NUM_OSCILLATORS = 4
NUM_NEURONS = 6  # of an oscillator; section 4.3, footnote: these oscillate most often
# Left and right of the first pair, which has the motor neurons, then of the second.
LATERAL = (1, 0, 3, 2)


class Network(NamedTuple):
    """A fully connected network.

    Attributes:
      weight: [i, j] of the synapse from neuron j to neuron i.
      bias: of each neuron.
      time_constant: of each neuron, s.
    """

    weight: Float[Array, "neuron neuron"]
    bias: Float[Array, " neuron"]
    time_constant: Float[Array, " neuron"]


def output(network: Network, state: Float[Array, " neuron"]) -> Float[Array, " neuron"]:
    """Returns the neurons' outputs, 0 to 1."""
    return jax.nn.sigmoid(state + network.bias)


def change(
    network: Network, state: Float[Array, " neuron"], given: Float[Array, " neuron"]
) -> Float[Array, " neuron"]:
    """Returns dy/dt, 1/s, of the states and what comes from outside."""
    return (network.weight @ output(network, state) - state + given) / network.time_constant


def step(
    network: Network,
    state: Float[Array, " neuron"],
    given: Float[Array, " neuron"],
    timestep: float | Float[Array, ""],
) -> Float[Array, " neuron"]:
    """Returns the states an Euler step (s) later."""
    return state + timestep * change(network, state, given)


class Coupled(NamedTuple):
    """Four identical oscillators and how they are coupled.

    Attributes:
      oscillator: each of them.
      lateral: weight from each neuron to its twin on the other side, the same both ways.
      sagittal: weight from each neuron of the second pair to its twin in the first pair on the same
        side; nothing goes the other way.
    """

    oscillator: Network
    lateral: Float[Array, "6"]
    sagittal: Float[Array, "6"]


def whole(coupled: Coupled) -> Network:
    """Returns the pattern generator as one network of 24 neurons, oscillator after oscillator."""
    own, _, _ = coupled.oscillator
    beside, behind = jnp.diag(coupled.lateral), jnp.diag(coupled.sagittal)
    nothing = jnp.zeros_like(own)
    rows = [
        [own, beside, behind, nothing],
        [beside, own, nothing, behind],
        [nothing, nothing, own, beside],
        [nothing, nothing, beside, own],
    ]
    return Network(
        weight=jnp.block(rows),
        bias=jnp.tile(coupled.oscillator.bias, NUM_OSCILLATORS),
        time_constant=jnp.tile(coupled.oscillator.time_constant, NUM_OSCILLATORS),
    )


def coupled_step(
    coupled: Coupled,
    state: Float[Array, "4 6"],
    given: Float[Array, "4 6"],
    timestep: float | Float[Array, ""],
) -> Float[Array, "4 6"]:
    """Returns the states of all oscillators an Euler step (s) later, as `step` of `whole` does.

    Args:
      coupled: the network.
      state: [oscillator, neuron], left and right of the first pair, then of the second.
      given: what comes from outside.
      timestep: s.
    """
    outputs = jax.vmap(output, (None, 0))(coupled.oscillator, state)
    received = given + coupled.lateral * outputs[jnp.array(LATERAL)]
    received += jnp.concatenate([coupled.sagittal * outputs[2:], jnp.zeros((2, NUM_NEURONS))])
    return jax.vmap(step, (None, 0, 0, None))(coupled.oscillator, state, received, timestep)
