"""The walker's drive by hand, its two senses, and both engines."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import evaluation, experiments, gaits
from mjxwalk.controllers.rayleigh_walker import (
    DAMPING,
    POSTURE,
    RISE_TIME,
    STIFFNESS,
    Clock,
    Gains,
    RayleighWalker,
)
from mjxwalk.envs import PlanarObservation

WALKER = RayleighWalker()
LATE = 10 * RISE_TIME


def _begin(genotype: Gains) -> Clock:
    """Returns the oscillators at heel strike at the time of the observations."""
    return WALKER.init(genotype)._replace(time=jnp.asarray(LATE))


def _observation(
    *, contact: tuple[bool, bool] = (True, True), pitch: float = 0.0, time: float = LATE
) -> PlanarObservation:
    return PlanarObservation(
        time=jnp.asarray(time),
        pitch=jnp.asarray(pitch),
        pitch_rate=jnp.zeros(()),
        angle=jnp.zeros((2, 3)),
        rate=jnp.zeros((2, 3)),
        contact=jnp.array(contact),
        ankle_x=jnp.array([0.1, -0.1]),
    )


def test_without_genes_hips_and_knees_are_to_go_where_the_adults_are_at_heel_strike():
    genotype = WALKER.template()
    _, action = WALKER.act(genotype, _begin(genotype), _observation())
    adults = gaits.adults()
    expected = [adults.hip[0], adults.knee[0], 0.0, adults.hip[50], adults.knee[50], 0.0]
    # The fit is within two degrees on average, and three here.
    np.testing.assert_allclose(jnp.rad2deg(action.target), expected, atol=3.0)
    np.testing.assert_allclose(action.stiffness, np.tile(STIFFNESS, 2))
    np.testing.assert_allclose(action.damping, np.tile(DAMPING, 2))
    np.testing.assert_array_equal(action.torque, 0.0)


def test_a_stride_later_the_targets_are_the_same():
    genotype = WALKER.template()
    num = round(1000 * gaits.ADULT_STRIDE_TIME)

    def step(clock: Clock, time: Any) -> tuple[Clock, Any]:
        return WALKER.act(genotype, clock, _observation()._replace(time=time))

    _, actions = jax.lax.scan(step, _begin(genotype), LATE + 0.001 * jnp.arange(num + 1.0))
    assert np.isfinite(actions.target).all()
    np.testing.assert_allclose(actions.target[-1], actions.target[0], atol=0.03)
    # Half a stride later left and right have changed places.
    np.testing.assert_allclose(actions.target[num // 2], np.roll(actions.target[0], 3), atol=0.05)


def test_genes_scale_shift_and_speed_up():
    genotype = WALKER.template()._replace(
        stiffness=jnp.log(jnp.array([2.0, 1.0, 1.0])), offset=jnp.array([0.0, 0.1, 0.0])
    )
    plain, moved = (
        WALKER.act(g, _begin(g), _observation())[1] for g in (WALKER.template(), genotype)
    )
    np.testing.assert_allclose(moved.stiffness[0], 2 * STIFFNESS[0], rtol=1e-6)
    np.testing.assert_allclose(moved.target - plain.target, [0, 0.1, 0, 0, 0.1, 0], atol=1e-6)
    fast = WALKER.template()._replace(tempo=jnp.log(2.0))
    once, _ = WALKER.act(fast, WALKER.init(fast), _observation(time=0.001))
    slow, _ = WALKER.act(WALKER.template(), WALKER.init(fast), _observation(time=0.002))
    np.testing.assert_allclose(once.oscillators.angle, slow.oscillators.angle, atol=1e-5)


def test_the_stance_hip_alone_pushes_a_leaning_trunk_back():
    genotype = WALKER.template()
    clock = _begin(genotype)
    _, action = WALKER.act(genotype, clock, _observation(contact=(True, False), pitch=0.1))
    np.testing.assert_allclose(action.torque, [-0.1 * POSTURE[0], 0, 0, 0, 0, 0], rtol=1e-6)
    _, far = WALKER.act(genotype, clock, _observation(contact=(False, True), pitch=-3.0))
    np.testing.assert_allclose(far.torque, [0, 0, 0, WALKER.torque_limit, 0, 0], rtol=1e-6)


def test_the_pattern_rises_from_standing():
    genotype = WALKER.template()
    _, action = WALKER.act(genotype, WALKER.init(genotype), _observation(time=0.0))
    np.testing.assert_array_equal(action.target, 0.0)


@pytest.mark.parametrize("share", [0.0, 1.0, 5.0])
def test_a_landing_moves_the_oscillators_to_heel_strike(share: float):
    genotype = WALKER.template()._replace(reset=jnp.asarray(share))
    clock = _begin(genotype)
    late = clock._replace(
        oscillators=jax.tree.map(lambda x: 0.5 * x, clock.oscillators),
        left_stance=jnp.zeros((), bool),
        contact=jnp.array([False, True]),
    )
    stayed = late._replace(contact=jnp.array([True, True]))
    after, _ = WALKER.act(genotype, late, _observation())
    wanted, _ = WALKER.act(genotype, clock if share else stayed, _observation())
    np.testing.assert_allclose(after.oscillators.angle, wanted.oscillators.angle, atol=1e-6)


def test_a_landing_of_the_right_foot_is_its_own_heel_strike():
    genotype = WALKER.template()._replace(reset=jnp.ones(()))
    clock = _begin(genotype)
    late = clock._replace(contact=jnp.array([True, False]))
    after, action = WALKER.act(genotype, late, _observation())
    _, before = WALKER.act(genotype, clock, _observation())
    np.testing.assert_allclose(action.target, np.roll(before.target, 3), atol=1e-6)
    assert after.contact.all()


@pytest.mark.slow
def test_both_engines_walk_alike():
    experiment = experiments.get("rayleigh-walk")
    population = jax.tree.map(lambda leaf: np.asarray(leaf)[None], experiment.template())
    terrains = experiment.sample_trials(jax.random.key(0), 2)
    lanes, mjx = (
        evaluation.make_evaluator(experiment, engine).evaluate(population, terrains)
        for engine in ("lanes", "mjx")
    )
    # About a second, until it falls; single precision grows apart by less than a millimetre.
    np.testing.assert_allclose(lanes.distance, mjx.distance, atol=1e-3)
    np.testing.assert_allclose(lanes.duration, mjx.duration, atol=5e-3)


def test_wrong_settings_are_named():
    with pytest.raises(ValueError, match="posture must be .* got -1"):
        RayleighWalker(posture=-1.0)
