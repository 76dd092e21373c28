"""Tests of the pattern generator as it drives the hips of the biped."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.controllers import ctrnn
from mjxwalk.controllers.ctrnn_walker import CtrnnWalker, Genes, Memory
from mjxwalk.engines import lanes
from mjxwalk.envs import Reil, SpatialObservation, State
from mjxwalk.envs.bodies.reil_trials import usual
from mjxwalk.rollout import advance, start

PAPERS = CtrnnWalker()
FEELING = CtrnnWalker(sense=4.0)
FLAT = usual().given(jnp.zeros((), jnp.int32))
OTHER_SIDE = jnp.array(ctrnn.LATERAL)


def drawn(seed: int) -> Genes:
    template = PAPERS.template()
    leaves, tree = jax.tree.flatten(template)
    keys = jax.random.split(jax.random.key(seed), len(leaves))
    return jax.tree.unflatten(
        tree,
        [
            jax.random.uniform(k, leaf.shape, minval=-1.0, maxval=1.0)
            for k, leaf in zip(keys, leaves, strict=True)
        ],
    )


def seen(time: float, *, pitch: float = 0.0, left_down: bool = True) -> SpatialObservation:
    return SpatialObservation(
        time=jnp.float32(time),
        torso=jnp.array([0.0, pitch, 0.0]),
        torso_rate=jnp.zeros(3),
        adduction=None,
        adduction_rate=None,
        angle=jnp.zeros((2, 4)),
        rate=jnp.zeros((2, 4)),
        contact=jnp.array([left_down, True]),
        ankle_x=jnp.zeros(2),
    )


def test_the_papers_network_has_sixty_genes() -> None:
    there = jax.tree.leaves(PAPERS.mask())
    assert sum(int(leaf.sum()) for leaf in there) == 60
    assert sum(int(leaf.sum()) for leaf in jax.tree.leaves(FEELING.mask())) == 84


def test_genes_reach_from_the_smallest_to_the_largest_value() -> None:
    lowest = jax.tree.map(lambda leaf: jnp.full(leaf.shape, -1.0), PAPERS.template())
    network = PAPERS.network(lowest)
    np.testing.assert_allclose(network.oscillator.time_constant, PAPERS.fastest, rtol=1e-5)
    np.testing.assert_allclose(network.oscillator.weight, -PAPERS.weight)
    # Six weights, the lateral one and half of the sagittal one: all inhibit, so half is plus 54.
    np.testing.assert_allclose(network.oscillator.bias, 0.5 * (6 * 16 + 8 + 4) - PAPERS.bias)
    middle = PAPERS.network(PAPERS.template()).oscillator.time_constant
    np.testing.assert_allclose(middle, np.sqrt(PAPERS.fastest * PAPERS.slowest), rtol=1e-5)


def test_time_comes_from_the_body_whatever_its_step() -> None:
    genes = drawn(0)

    def state_after(timestep: float, num: int) -> np.ndarray:
        def one(memory: Memory, time: jax.Array) -> tuple[Memory, None]:
            return PAPERS.act(genes, memory, seen(0.0)._replace(time=time))[0], None

        times = timestep * jnp.arange(1, num + 1)
        return np.asarray(jax.lax.scan(one, PAPERS.init(genes), times)[0].state)

    # Euler's method is of first order; the smallest time constant is 50 ms.
    np.testing.assert_allclose(state_after(0.001, 300), state_after(0.0005, 600), atol=0.5)


def test_a_motor_neuron_moves_its_hip_within_the_swing() -> None:
    genes, memory = drawn(1), PAPERS.init(drawn(1))
    _, targets = PAPERS.act(genes, memory, seen(0.0))
    bias = PAPERS.network(genes).oscillator.bias[0]
    outputs = 1.0 / (1.0 + np.exp(-(np.array([1.0, -1.0]) + np.asarray(bias))))
    expected = PAPERS.forward + PAPERS.swing * (outputs - 0.5)
    np.testing.assert_allclose(targets.target, expected, rtol=1e-4)


def test_senses_reach_the_network_only_where_it_has_them() -> None:
    genes = drawn(2)
    for controller, changes in ((PAPERS, False), (FEELING, True)):
        memory = controller.init(genes)
        usually, _ = controller.act(genes, memory, seen(0.001))
        for other in (seen(0.001, pitch=0.1), seen(0.001, left_down=False)):
            otherwise, _ = controller.act(genes, memory, other)
            assert bool(jnp.any(otherwise.state[:2] != usually.state[:2])) == changes
            np.testing.assert_array_equal(otherwise.state[2:], usually.state[2:])


def test_genes_without_senses_drive_a_feeling_network_as_the_papers() -> None:
    genes = drawn(3)._replace(sense=jnp.zeros((4, 6)))
    after = [c.act(genes, c.init(genes), seen(0.001))[0] for c in (PAPERS, FEELING)]
    np.testing.assert_array_equal(after[0].state, after[1].state)


def mirrored(values: np.ndarray) -> np.ndarray:
    sign = np.ones(14)
    sign[[1, 3, 5]] = -1.0  # y, yaw, roll
    return np.asarray(values)[[*range(6), *range(10, 14), *range(6, 10)]] * sign


def test_swapping_left_and_right_mirrors_the_walk() -> None:
    env = Reil(max_flight_time=9.0)

    def walk(genes: Genes, swapped: jax.Array) -> State:
        walker = start(env, FEELING, genes, FLAT)
        state = walker.memory.state
        other = jnp.where(swapped, state[OTHER_SIDE], state)
        walker = walker._replace(memory=walker.memory._replace(state=other))
        return jax.lax.fori_loop(
            0, 400, lambda _, now: advance(env, FEELING, genes, FLAT, now), walker
        ).state

    genes = jax.tree.map(lambda leaf: np.stack([leaf, leaf]), drawn(8))
    states = lanes.vmap(walk)(genes, np.array([False, True]))
    # The legs do not move alike, and the trunk rolls to a side.
    assert np.ptp(states.qpos[0, [7, 11]]) > 0.03 and abs(states.qpos[0, 5]) > 1e-3
    # Sums over the legs run in another order; contact carries that rounding on.
    np.testing.assert_allclose(mirrored(states.qpos[1]), states.qpos[0], atol=1e-3)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"weight": 0.0}, "weight must be a number above 0, got 0.0"),
        ({"sense": -1.0}, "sense must be 0 or above, got -1.0"),
        ({"slowest": 0.01}, "slowest must be at least fastest, got 0.01"),
    ],
)
def test_wrong_settings_are_refused(settings: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        CtrnnWalker(**settings)
