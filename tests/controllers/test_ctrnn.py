"""Tests of recurrent networks: against scipy, and the symmetries of four coupled ones."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import expit

from mjxwalk.controllers import ctrnn
from mjxwalk.controllers.ctrnn import Coupled, Network

RANDOM = np.random.default_rng(3)
# Beer (1995): two neurons that excite themselves, and of which the second inhibits the first.
TWO = Network(
    weight=jnp.array([[4.5, -1.0], [1.0, 4.5]]),
    bias=jnp.array([-1.75, -2.75]),
    time_constant=jnp.ones(2),
)


def simulate(network: Network, start: Any, timestep: float, num: int) -> Any:
    """States at every step, the start left out."""

    def one(state: Any, _: None) -> Any:
        after = ctrnn.step(network, state, jnp.zeros_like(state), timestep)
        return after, after

    return np.asarray(jax.lax.scan(one, jnp.asarray(start, jnp.float32), length=num)[1])


def textbook(network: Network, start: Any, times: Any) -> Any:
    """States at some times by an adaptive method, from the equation as Beer writes it."""
    weight, bias, tau = (np.asarray(leaf, np.float64) for leaf in network)

    def derivative(_: float, y: Any) -> Any:
        total = np.zeros_like(y)
        for i in range(len(y)):
            total[i] = sum(weight[i, j] * expit(y[j] + bias[j]) for j in range(len(y)))
        return (total - y) / tau

    solved = solve_ivp(derivative, (0.0, times[-1]), start, "LSODA", times, rtol=1e-8, atol=1e-8)
    return solved.y.T


def rises(signal: Any) -> Any:
    """Steps at which a signal rises through its middle."""
    above = signal > 0.5 * (signal.max() + signal.min())
    return np.flatnonzero(above[1:] & ~above[:-1])


def test_two_neurons_run_round_the_limit_cycle_that_scipy_finds() -> None:
    dt, num = 0.005, 40_000
    ours = simulate(TWO, [0.5, 0.5], dt, num)[num // 2 :]
    theirs = textbook(TWO, [-3.0, 4.0], dt * np.arange(1, num + 1))[num // 2 :]
    # Another start ends on the same cycle, which is no point.
    periods = [dt * np.diff(rises(states[:, 0])).mean() for states in (ours, theirs)]
    np.testing.assert_allclose(periods[0], periods[1], rtol=0.01)  # Euler: of the order of dt
    for extreme in (np.min, np.max):
        np.testing.assert_allclose(extreme(ours, axis=0), extreme(theirs, axis=0), atol=0.02)
    assert np.all(np.ptp(ours, axis=0) > 0.5)


def coupled(lateral: float, sagittal: float) -> Coupled:
    oscillator = Network(
        weight=jnp.asarray(RANDOM.uniform(-6.0, 6.0, (6, 6)), jnp.float32),
        bias=jnp.asarray(RANDOM.normal(size=6), jnp.float32),
        time_constant=jnp.asarray(RANDOM.uniform(0.05, 0.5, 6), jnp.float32),
    )
    return Coupled(
        oscillator,
        jnp.asarray(lateral * RANDOM.normal(size=6), jnp.float32),
        jnp.asarray(sagittal * RANDOM.normal(size=6), jnp.float32),
    )


def steps(network: Coupled, start: Any, timestep: float, num: int) -> Any:
    def one(state: Any, _: None) -> Any:
        after = ctrnn.coupled_step(network, state, jnp.zeros((4, 6)), timestep)
        return after, after

    return np.asarray(jax.lax.scan(one, jnp.asarray(start, jnp.float32), length=num)[1])


def test_decoupled_oscillators_are_four_textbook_networks() -> None:
    network, start = coupled(0.0, 0.0), RANDOM.normal(size=(4, 6))
    dt, num = 0.0002, 5_000
    ours = steps(network, start, dt, num)
    for place in range(4):
        theirs = textbook(network.oscillator, start[place], dt * np.arange(1, num + 1))
        # Euler's error is of the order of dt over the time constants, some 0.4 %.
        np.testing.assert_allclose(ours[:, place], theirs, atol=0.03)


def test_coupled_oscillators_are_one_network_of_twenty_four_neurons() -> None:
    network, start = coupled(3.0, 2.0), RANDOM.normal(size=(4, 6))
    ours = steps(network, start, 0.005, 100)
    theirs = simulate(ctrnn.whole(network), start.ravel(), 0.005, 100)
    np.testing.assert_allclose(ours.reshape(100, 24), theirs, atol=1e-4)  # order of the sums
    weight = np.asarray(ctrnn.whole(network).weight)
    # Sixty numbers make all: each neuron has six synapses of its own oscillator, one from the
    # other side, and in the first pair one from the second.
    np.testing.assert_array_equal((weight != 0.0).sum(axis=1), [8] * 12 + [7] * 12)


def test_swapped_starts_make_swapped_motions() -> None:
    network, start = coupled(3.0, 2.0), RANDOM.normal(size=(4, 6))
    swapped = steps(network, start[[1, 0, 3, 2]], 0.005, 400)
    np.testing.assert_array_equal(swapped[:, [1, 0, 3, 2]], steps(network, start, 0.005, 400))


def test_sides_that_start_alike_stay_alike() -> None:
    start = np.repeat(RANDOM.normal(size=(2, 6)), 2, axis=0)
    states = steps(coupled(3.0, 2.0), start, 0.005, 400)
    np.testing.assert_array_equal(states[:, 0], states[:, 1])


def test_sides_that_start_as_opposites_stay_in_antiphase() -> None:
    # Beer's pair and four neurons that do nothing, with biases where half of what comes in at most
    # is the threshold: states counted from there may change their sign, and then all else does.
    weight = np.zeros((6, 6))
    weight[:2, :2] = TWO.weight
    lateral = np.array([-1.0, 0, 0, 0, 0, 0])
    bias = -0.5 * (weight.sum(axis=1) + lateral)
    leaves = [jnp.asarray(leaf, jnp.float32) for leaf in (weight, bias, np.full(6, 0.05))]
    network = Coupled(Network(*leaves), jnp.asarray(lateral, jnp.float32), jnp.zeros(6))
    apart = RANDOM.normal(size=6)
    start = np.stack([apart - bias, -apart - bias, -bias, -bias])
    outputs = expit(steps(network, start, 0.005, 4_000) + bias)[:, :2, 0]
    np.testing.assert_allclose(outputs[:, 1], 1.0 - outputs[:, 0], atol=1e-3)  # rounding grows
    left, right = rises(outputs[2_000:, 0]), rises(outputs[2_000:, 1])
    period = np.diff(left).mean()
    assert len(left) > 3 and np.ptp(outputs[2_000:, 0]) > 0.3
    shift = (right[1] - left[0]) / period % 1.0
    np.testing.assert_allclose(shift, 0.5, atol=0.01)
