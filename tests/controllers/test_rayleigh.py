"""Rayleigh oscillators against scipy's integrator, harmonic balance, and what the thesis shows."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mjxwalk import gaits
from mjxwalk.controllers import rayleigh
from mjxwalk.controllers.rayleigh import Genes, Motion, Network

TIMESTEP = 0.01
MU = 5.7  # rad/s, a human stride


def _start(*angles: float) -> Motion:
    return Motion(jnp.array(angles), jnp.zeros(len(angles)))


def _scipy(network: Network, start: Motion, times: np.ndarray) -> np.ndarray:
    """Returns angles [time, oscillator], by an integrator and equations of its own."""
    alpha, p, mu, centre, same, product = (np.asarray(part, np.float64) for part in network)
    size = len(alpha)

    def slope(_: float, state: np.ndarray) -> np.ndarray:
        a, v = state[:size], state[size:]
        accelerations = []
        for i in range(size):
            total = alpha[i] * (1 - p[i] * v[i] ** 2) * v[i] - mu[i] ** 2 * (a[i] - centre[i])
            for j in range(size):
                total += same[i, j] * (v[i] - v[j]) + product[i, j] * v[j] * (a[j] - centre[j])
            accelerations.append(total)
        return np.concatenate([v, accelerations])

    begin = np.concatenate([np.asarray(start.angle), np.asarray(start.rate)]).astype(np.float64)
    solved = solve_ivp(slope, (0, times[-1]), begin, t_eval=times, rtol=1e-12, atol=1e-12)
    return solved.y[:size].T


def _thesis(amplitude: float = 20.0) -> Network:
    return rayleigh.four_joints(
        rayleigh.thesis_genes(),
        mu=jnp.full(4, MU),
        amplitude=jnp.full(4, amplitude),
        centre=jnp.array([10.0, 10.0, 30.0, 30.0]),
    )


@pytest.mark.parametrize("p", [5.0, 50.0])
@pytest.mark.parametrize("mu", [0.5, 1.0])
def test_one_oscillator_moves_as_scipy_says(p: float, mu: float):
    network = rayleigh.alone(alpha=1.0, p=p, mu=mu, centre=0.3)
    start = _start(0.5)
    motion = rayleigh.simulate(network, start, timestep=TIMESTEP, num_steps=3000)
    times = TIMESTEP * np.arange(3001)
    # Single precision over 3000 steps; the amplitude is about 0.6.
    np.testing.assert_allclose(motion.angle, _scipy(network, start, times), atol=2e-4)


def test_the_four_joints_move_as_scipy_says():
    network = _thesis()
    start = rayleigh.on_cycle(network, jnp.full(4, 20.0), jnp.array([0.1, 3.0, 1.6, -1.5]))
    motion = rayleigh.simulate(network, start, timestep=TIMESTEP, num_steps=500)
    # Single precision, and 57 steps a cycle, on angles of up to 50 degrees.
    times = TIMESTEP * np.arange(501)
    np.testing.assert_allclose(motion.angle, _scipy(network, start, times), atol=5e-3)


def test_the_equations_have_the_terms_of_the_thesis_and_no_others():
    """Equation 15, by hand: the left knee with the hip of its side and the other knee."""
    genes = Genes(jnp.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]), jnp.full(4, 0.9))
    network = rayleigh.four_joints(
        genes, mu=jnp.full(4, 2.0), amplitude=jnp.ones(4), centre=jnp.array([1.0, 2.0, 3.0, 4.0])
    )
    motion = Motion(jnp.array([3.0, 1.0, 2.0, 5.0]), jnp.array([0.5, -1.0, 2.0, 1.5]))
    p3 = 4 * (0.9 + 2 * 0.6) / (3 * 0.9 * 4.0)
    own = 0.9 * (1 - p3 * 4.0) * 2.0 - 4.0 * (2.0 - 3.0)
    expected = own + 0.5 * 0.5 * (3.0 - 1.0) + 0.6 * (2.0 - 1.5)
    change = rayleigh.change(network, motion)
    np.testing.assert_array_equal(change.angle, motion.rate)
    np.testing.assert_allclose(change.rate[2], expected, rtol=1e-6)


def test_the_integrator_is_of_fourth_order():
    network = rayleigh.alone(alpha=1.0, p=5.0, mu=1.0)
    with jax.enable_x64(True):
        exact = _scipy(network, _start(0.5), np.array([0.0, 4.0]))[-1]
        network = Network(*(jnp.asarray(np.asarray(part, np.float64)) for part in network))
        start = _start(0.5)
        errors = [
            abs(rayleigh.simulate(network, start, timestep=4.0 / n, num_steps=n).angle[-1] - exact)
            for n in (80, 160)
        ]
    # Half the step, a sixteenth of the error, and a little for the next order.
    assert 13 < float(errors[0][0] / errors[1][0]) < 20


@pytest.mark.parametrize("alpha", [0.05, 0.2])
@pytest.mark.parametrize("amplitude", [10.0, 30.0])
def test_an_oscillator_has_the_amplitude_and_frequency_of_harmonic_balance(
    alpha: float, amplitude: float
):
    p = float(rayleigh.harmonic_balance(alpha, 0.0, MU, amplitude))
    assert rayleigh.harmonic_amplitude(alpha, 0.0, MU, p) == pytest.approx(amplitude)
    network = rayleigh.alone(alpha=alpha, p=p, mu=MU)
    start = _start(0.7 * amplitude)
    motion = rayleigh.simulate(network, start, timestep=TIMESTEP, num_steps=30_000)
    angle = np.asarray(motion.angle)[-5_000:, 0]
    # The formula's own error is of the order of (alpha / mu)^2, about a thousandth here.
    assert np.ptp(angle) / 2 == pytest.approx(amplitude, rel=3e-3)
    ups = np.flatnonzero((angle[:-1] < 0) & (angle[1:] >= 0))
    period = TIMESTEP * (ups[-1] - ups[0]) / (len(ups) - 1)
    assert 2 * np.pi / period == pytest.approx(MU, rel=3e-3)


def test_an_antiphase_pair_has_the_amplitude_of_harmonic_balance():
    network = _thesis(amplitude=20.0)
    start = rayleigh.on_cycle(
        network, jnp.full(4, 15.0), jnp.array([0.0, np.pi, np.pi / 2, -np.pi / 2])
    )
    # Weak coupling, so that the amplitude takes long: alpha + 2 k is 0.4 a second.
    motion = rayleigh.simulate(network, start, timestep=TIMESTEP, num_steps=3_000)
    angle = np.asarray(motion.angle)[-300:]
    # The products of hip and knee, which the formula leaves out, move it by a few percent.
    np.testing.assert_allclose(np.ptp(angle, axis=0) / 2, 20.0, rtol=0.05)


def test_left_and_right_are_driven_into_antiphase():
    network = _thesis()
    # Nearly in step at first.
    start = rayleigh.on_cycle(network, jnp.full(4, 20.0), jnp.array([0.0, 0.5, 1.0, 1.5]))
    motion = rayleigh.simulate(network, start, timestep=TIMESTEP, num_steps=10_000)
    angle = np.asarray(motion.angle)
    first = np.corrcoef(angle[:100].T)
    last = np.corrcoef(angle[-1000:].T)
    for left, right in ((0, 1), (2, 3)):
        assert first[left, right] > 0
        assert last[left, right] < -0.99


def test_p_lowers_the_amplitude_and_mu_raises_the_frequency():
    """Figures 2.4, 2.6 and 2.7 of the thesis."""

    def course(p: float, mu: float) -> np.ndarray:
        network = rayleigh.alone(alpha=1.0, p=p, mu=mu)
        motion = rayleigh.simulate(network, _start(0.1), timestep=TIMESTEP, num_steps=10_000)
        return np.asarray(motion.angle)[2_000:, 0]

    def crossings(angle: np.ndarray) -> int:
        return int(np.count_nonzero((angle[:-1] < 0) & (angle[1:] >= 0)))

    usual, tight, fast = course(5.0, 0.5), course(50.0, 0.5), course(5.0, 1.0)
    # By harmonic balance the amplitude goes with the root of p.
    assert np.ptp(usual) / np.ptp(tight) == pytest.approx(np.sqrt(10), rel=0.01)
    assert crossings(fast) > 1.5 * crossings(usual)


def test_one_oscillator_a_knee_is_twelve_degrees_off_a_human_one():
    series = [gaits.harmonics(curve, 1) for curve in (gaits.adults().hip, gaits.adults().knee)]
    each = [series[joint] for joint in (0, 0, 1, 1)]
    turned = np.array([0.0, np.pi, 0.0, np.pi])
    mu = 2 * np.pi / gaits.ADULT_STRIDE_TIME
    network = rayleigh.four_joints(
        rayleigh.thesis_genes(),
        mu=jnp.full(4, mu),
        amplitude=jnp.array([float(s.amplitude[0]) for s in each]),
        centre=jnp.array([s.mean for s in each]),
    )
    amplitude = jnp.array([float(s.amplitude[0]) for s in each])
    start = rayleigh.on_cycle(
        network, amplitude, jnp.array([float(s.phase[0]) for s in each]) + turned
    )
    timestep = gaits.ADULT_STRIDE_TIME / gaits.NUM_POINTS
    motion = rayleigh.simulate(network, start, timestep=timestep, num_steps=499)
    off = np.asarray(motion.angle).reshape(5, gaits.NUM_POINTS, 4) - gaits.adults().four_joints
    rms = np.sqrt(np.mean(off**2, axis=(0, 1)))
    assert 2 < rms[0] < 3.5
    assert 12 < rms[2] < 13.5
