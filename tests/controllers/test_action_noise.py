"""Noise on actions: its distribution, and what of a trial it depends on."""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.stats
from jaxtyping import Array, Float, Int

from mjxwalk.controllers import Controller, action_noise
from mjxwalk.engines import lanes
from mjxwalk.envs import Flame, FlatEnv, Planar7, Trials, TrialState
from mjxwalk.envs.motor import Action
from mjxwalk.evaluation import evaluate
from mjxwalk.experiments.experiment import Experiment, StrategyChoice
from mjxwalk.rollout import Walk, advance, rollout, start

MOTORS, STEPS = 3, 12


class State(NamedTuple):
    """All actions that there were, by step."""

    qpos: Float[Array, "step motor"]
    trial: TrialState


@dataclasses.dataclass(frozen=True, kw_only=True)
class Recorder(FlatEnv):
    """Keeps the actions of a trial; its fitness is their sum."""

    observation_names = ("nothing",)
    action_names = tuple(f"motor {motor}" for motor in range(MOTORS))
    num_draws = 2
    timestep: float = 1.0
    max_time: float = float(STEPS)

    def reset(self, given: Any, /) -> State:
        """Returns a trial without actions."""
        return State(jnp.zeros((STEPS, MOTORS)), TrialState.begin())

    def observe(self, state: State, /) -> Float[Array, "1"]:
        """Returns a zero."""
        return jnp.zeros(1)

    def step(self, state: State, action: Any, given: Any, /) -> State:
        """Returns the actions with one more."""
        now = (jnp.arange(STEPS) == state.trial.num_steps)[:, None]
        return State(jnp.where(now, action, state.qpos), self.count(state.trial))

    def fitness(self, state: State, /) -> Float[Array, ""]:
        """Returns the sum of all actions."""
        return state.qpos.sum()


@dataclasses.dataclass(frozen=True)
class Still(Controller):
    """Asks for a number of its weights, and holds it for some steps."""

    steps: int = 1

    def template(self) -> Float[Array, " motor"]:
        """Returns zeros."""
        return jnp.zeros(MOTORS)

    def act(self, genotype: Any, memory: Any, observation: Any, /) -> tuple[Any, Any]:
        """Returns the weights."""
        return memory, genotype

    def steps_held(self) -> int:
        """Returns what the settings say."""
        return self.steps


class Stubborn(Still):
    """Has actions that are no numbers."""

    def act(self, genotype: Any, memory: Any, observation: Any, /) -> tuple[Any, Any]:
        """Returns the weights as torques."""
        return memory, Action(genotype, genotype, genotype, genotype)


def recorded(env: Recorder, controller: Controller, trials: Trials, row: int = 0) -> np.ndarray:
    """Returns the actions of a trial, one step after another, as replays go through it."""
    given, genotype = jax.tree.map(jnp.asarray, trials.given(row)), jnp.zeros(MOTORS)
    walk = start(env, controller, genotype, given)
    step = jax.jit(lambda walk: advance(env, controller, genotype, given, Walk(*walk)))
    for _ in range(STEPS):
        walk = step(walk)
    return np.asarray(walk.state.qpos)


def drawn(seeds: Any, turns: int, num: int) -> np.ndarray:
    """Returns noise [seed, turn, number]."""
    of_turns = jax.vmap(action_noise.normal, (None, 0, None))
    of_all = jax.vmap(of_turns, (0, None, None))
    return np.asarray(of_all(jnp.asarray(seeds, jnp.uint32), jnp.arange(turns), num))


@pytest.mark.parametrize("seeds", [np.arange(200), np.arange(200) * 0x9E3779B9 % 2**32])
def test_numbers_are_standard_normal_and_independent(seeds: np.ndarray) -> None:
    noise = drawn(seeds, 150, 4)
    assert abs(noise.mean()) < 4 / np.sqrt(noise.size)
    assert abs(noise.std() - 1) < 4 / np.sqrt(2 * noise.size)
    assert scipy.stats.kstest(noise.ravel(), "norm").pvalue > 1e-3
    assert len(np.unique(noise.astype(np.float64) @ np.sqrt([2.0, 3.0, 5.0, 7.0]))) == 200 * 150
    for one, other in (
        (noise[..., :-1], noise[..., 1:]),
        (noise[:, :-1], noise[:, 1:]),
        (noise[:-1], noise[1:]),
        (noise[:, :-1, :-1], noise[:, 1:, 1:]),
    ):
        for a, b in ((one, other), (one**2, other**2)):
            assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 4 / np.sqrt(a.size)


def test_engines_draw_the_same_up_to_rounding() -> None:
    def draw(seed: Int[Array, ""], turn: Int[Array, ""]) -> Float[Array, " num"]:
        return action_noise.normal(seed, turn, 5)

    seeds = np.arange(1000, dtype=np.uint32) * np.uint32(4_000_037)
    turns = np.arange(1000, dtype=np.int32)
    one, other = jax.jit(jax.vmap(draw))(seeds, turns), lanes.vmap(draw, (0, 0))(seeds, turns)
    np.testing.assert_allclose(one, other, atol=3e-6)


def test_trials_of_an_engine_are_those_of_the_other() -> None:
    env = Recorder(action_noise=0.1)
    trials = env.sample_trials(jax.random.key(0), 3)
    weights = np.zeros((2, MOTORS), np.float32)
    found = [
        evaluate(env, Still(2), weights, trials, engine=engine).fitness
        for engine in ("mjx", "lanes")
    ]
    np.testing.assert_allclose(found[0], found[1], atol=1e-5)
    sums = [recorded(env, Still(2), trials, row).sum() for row in range(3)]
    np.testing.assert_allclose(found[0], [sums, sums], atol=1e-5)
    assert len(np.unique(np.round(sums, 5))) == 3


def test_every_action_has_noise_of_its_own_and_that_of_its_deviation() -> None:
    env = Recorder(action_noise=0.1)
    trials = env.sample_trials(jax.random.key(0), 40)
    noise = np.stack([recorded(env, Still(), trials, row) for row in range(3)])
    assert len(np.unique(noise)) == noise.size
    wider = recorded(Recorder(action_noise=0.2), Still(), trials, 2)
    np.testing.assert_allclose(wider, 2 * noise[2], rtol=1e-5)
    np.testing.assert_allclose(noise / 0.1, drawn(trials.noise[:3], STEPS, MOTORS), rtol=1e-5)


def test_steps_of_an_action_that_is_held_have_the_same_noise() -> None:
    env = Recorder(action_noise=0.1)
    trials = env.sample_trials(jax.random.key(0), 1)
    noise = recorded(env, Still(3), trials)
    assert (noise.reshape(4, 3, MOTORS) == noise[::3, None]).all()
    np.testing.assert_array_equal(noise[::3], recorded(env, Still(), trials)[:4])


@pytest.mark.parametrize("env", [Recorder(), Planar7(), Flame()], ids=["flat", "plane", "space"])
def test_nothing_else_of_a_trial_changes_and_without_noise_nothing(env: Any) -> None:
    noisy = dataclasses.replace(env, action_noise=0.01)
    plain, trials = (each.sample_trials(jax.random.key(0), 5) for each in (env, noisy))
    assert plain.noise is None
    assert trials.noise.dtype == np.uint32 and len(np.unique(trials.noise)) == 5
    jax.tree.map(np.testing.assert_array_equal, plain, trials._replace(noise=None))


def test_walkers_are_tested_without_noise_unless_the_test_asks_for_it() -> None:
    experiment = Experiment(
        name="recorder",
        env=Recorder(action_noise=0.1),
        controller=Still(),
        strategy=StrategyChoice(name="snes", options={"sigma": 0.3}),
        population_size=4,
        generations=1,
        terrains_per_evaluation=1,
    )
    assert experiment.as_tested() == dataclasses.replace(experiment, env=Recorder())
    for changed, there in (({"action_noise": 0.2}, 0.2), ({"max_time": 5.0}, 0.0)):
        tested = dataclasses.replace(experiment, test_settings=changed).as_tested()
        assert tested.env.action_noise == there and tested.test_settings == {}
    assert tested.env.max_time == 5.0
    silent = dataclasses.replace(experiment, env=Recorder())
    assert silent.as_tested() is silent


def test_actions_that_are_no_numbers_are_refused_in_a_sentence() -> None:
    env = Recorder(action_noise=0.1)
    given = env.sample_trials(jax.random.key(0), 1).given(0)
    with pytest.raises(ValueError, match="action_noise must be 0 where .* not numbers .* got 0.1"):
        rollout(env, Stubborn(), jnp.zeros(MOTORS), given)
    with pytest.raises(ValueError, match="action_noise must be 0 or above, got -1"):
        Recorder(action_noise=-1.0)
