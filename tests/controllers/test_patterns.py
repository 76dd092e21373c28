"""Networks that draw joint angles: their terms by hand, and cycles that they return to."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import gaits
from mjxwalk.controllers import patterns, rayleigh
from mjxwalk.controllers.patterns import FourJoints, HarmonicGenes, HarmonicLegs, PatternGenerator
from mjxwalk.controllers.rayleigh import Motion
from mjxwalk.controllers.rayleigh_walker import fitted

TIMESTEP = gaits.ADULT_STRIDE_TIME / gaits.NUM_POINTS
LEGS = HarmonicLegs()


def _shipped() -> tuple[Any, Any]:
    genes = HarmonicGenes(**{name: jnp.array(value) for name, value in fitted().genes.items()})
    return LEGS.begin(genes, gaits.adults())


def _run(network: Any, state: Any, cycles: int) -> tuple[Any, np.ndarray]:
    """Returns the state some of the human's cycles later, and the angles until then."""

    def one(state: Any, _: None) -> tuple[Any, Any]:
        return LEGS.step(network, state, TIMESTEP), LEGS.read(network, state).angle

    end, angles = jax.lax.scan(one, state, length=cycles * gaits.NUM_POINTS)
    return end, np.asarray(angles, np.float64)


def _off(angles: np.ndarray, cycle: np.ndarray) -> float:
    """Returns how far the farthest of some angles is from a cycle, wherever it is on it."""
    samples = np.arange(len(cycle))
    dense = np.linspace(0, len(cycle) - 1, 20 * len(cycle))
    path = np.stack([np.interp(dense, samples, joint) for joint in cycle.T], axis=1)
    return max(float(np.min(np.max(np.abs(path - point), axis=1))) for point in angles)


def test_the_thesis_network_starts_in_the_phase_of_the_gait():
    network, start = FourJoints().begin(rayleigh.thesis_genes(), gaits.adults())
    series = gaits.harmonics(gaits.adults().hip, 1)
    at = gaits.evaluate(series, np.array([0.0, np.pi]))
    np.testing.assert_allclose(start.angle[:2], at, rtol=1e-5)
    rate = 2 * np.pi / gaits.ADULT_STRIDE_TIME * gaits.evaluate(series, np.array([0.0]), 1)
    np.testing.assert_allclose(start.rate[0], rate[0], rtol=1e-5)
    np.testing.assert_allclose(network.mu, 2 * np.pi / gaits.ADULT_STRIDE_TIME, rtol=1e-6)


def test_a_gait_without_time_takes_as_long_as_adults():
    gait = gaits.Gait(name="", hip=gaits.adults().hip, knee=gaits.adults().knee)
    assert patterns.stride_time(gait) == gaits.ADULT_STRIDE_TIME


def test_harmonics_have_the_terms_that_the_docstring_says():
    """By hand, of the second harmonic of the left leg and the first of the right."""
    genes = LEGS.template()._replace(alpha=jnp.array([0.5, 0.6, 0.7]))
    network, _ = LEGS.begin(genes, gaits.adults())
    state = Motion(
        jnp.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]), jnp.array([[2.0, 3, 4], [5, 6, 7]])
    )
    short = 1e-4
    after = LEGS.step(network, state, short)
    mu = 2 * np.pi / gaits.ADULT_STRIDE_TIME
    p2 = 4 / (3 * (2 * mu) ** 2)
    second = 0.6 * (1 - p2 * 9.0) * 3.0 - (2 * mu) ** 2 * 0.2 + 5.0 * 2.0 * 0.1
    p1 = 4 * (0.5 + 2.0) / (3 * 0.5 * mu**2)
    first = 0.5 * (1 - p1 * 25.0) * 5.0 - mu**2 * 0.4 + 1.0 * (5.0 - 2.0)
    # A step so short that only the slope at its start counts, to a hundredth.
    change = (np.asarray(after.rate) - np.asarray(state.rate)) / short
    assert change[0, 1] == pytest.approx(second, rel=0.02)
    assert change[1, 0] == pytest.approx(first, rel=0.02)


def test_rates_are_the_slopes_of_angles():
    network, state = _shipped()
    before, after = (LEGS.step(network, state, by) for by in (-0.001, 0.001))
    slope = (LEGS.read(network, after).angle - LEGS.read(network, before).angle) / 0.002
    # Single precision leaves a hundredth of a degree a second times a thousand.
    np.testing.assert_allclose(LEGS.read(network, state).rate, slope, atol=0.5)


def test_the_shipped_oscillators_follow_the_adults_within_two_degrees():
    """Over the whole cycle, in the phase in which they are shipped."""
    network, _ = _shipped()
    start = Motion(jnp.array(fitted().angle), jnp.array(fitted().rate))
    _, angles = _run(network, start, 1)
    rms = np.sqrt(np.mean((angles - gaits.adults().four_joints) ** 2, axis=0))
    assert rms.max() < 2.0
    assert rms[:2].max() < 1.0


@pytest.mark.parametrize("factor", [0.2, 3.0])
def test_the_shipped_oscillators_return_to_their_cycle_after_a_kick(factor: float):
    network, start = _shipped()
    settled, _ = _run(network, start, 100)
    _, cycle = _run(network, settled, 2)
    kicked = LEGS.kick(network, settled, factor)
    end, first = _run(network, kicked, 1)
    assert _off(first, cycle) > 8.0
    end, _ = _run(network, end, 30)
    _, last = _run(network, end, 1)
    # What is left is the drawing's own width, and how it is compared.
    assert _off(last, cycle) < 0.2


def test_the_right_leg_is_half_a_cycle_behind_whatever_the_start():
    network, start = _shipped()
    # Nearly in step.
    disturbed = Motion(start.angle.at[1].set(start.angle[0] * 0.9), start.rate.at[1, 0].add(1.0))
    settled, _ = _run(network, disturbed, 150)
    _, angles = _run(network, settled, 3)
    assert np.corrcoef(angles[:, 0], np.roll(angles[:, 1], 50))[0, 1] > 0.98
    assert np.corrcoef(angles[:, 0], angles[:, 1])[0, 1] < -0.5


def test_a_kick_leaves_centres_and_the_right_leg_alone():
    network, start = FourJoints().begin(rayleigh.thesis_genes(), gaits.adults())
    kicked = FourJoints().kick(network, start, 0.0)
    np.testing.assert_allclose(kicked.angle[::2], network.centre[::2])
    np.testing.assert_array_equal(kicked.rate[::2], 0.0)
    np.testing.assert_allclose(kicked.angle[1::2], start.angle[1::2], rtol=1e-6)


def test_tables_name_every_gene():
    networks: list[PatternGenerator] = [FourJoints(), LEGS]
    for network in networks:
        genotype = network.template()
        rows = network.table(genotype)
        assert len(rows) == sum(leaf.size for leaf in jax.tree.leaves(genotype))
        assert len({name for name, _ in rows}) == len(rows)


def test_wrong_settings_are_named():
    with pytest.raises(ValueError, match="num_harmonics must be from 2 to 50, got 1"):
        HarmonicLegs(num_harmonics=1)
    with pytest.raises(ValueError, match="largest must be positive, got 0"):
        FourJoints(largest=0.0)
