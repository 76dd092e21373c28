"""An engine from outside: registered by name, it evaluates and replays as ours do."""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import engines, evaluation, replay
from mjxwalk.controllers import Controller
from mjxwalk.engines import registry
from mjxwalk.envs import Trial, Trials, TrialState
from mjxwalk.rollout import Outcome, rollout


class PlainMapped:
    """What `jax.jit(jax.vmap(function))` gives, and how often it was asked to compile."""

    compile_s = 0.0

    def __init__(self, function: Callable[..., Any], in_axes: Any) -> None:
        self._run = jax.jit(jax.vmap(function, in_axes))

    def prepare(self, *args: Any) -> None:
        self._run.lower(*args).compile()
        self.compile_s += 1.0

    def __call__(self, *args: Any) -> Any:
        return self._run(*args)


class Plain:
    """`jax.vmap` as an engine."""

    def vmap(
        self, function: Callable[..., Any], /, in_axes: Any = 0, *, results: Any = None
    ) -> PlainMapped:
        return PlainMapped(function, in_axes)

    def devices(self) -> str:
        return "whatever JAX takes"


class Sliding(NamedTuple):
    """State of a point that a constant force pushes along the ground."""

    qpos: Any
    speed: Any
    trial: TrialState


@dataclasses.dataclass(frozen=True)
class Slope:
    """A point mass on a line; its trial ends after a while, or where the ground is high."""

    timestep: float = 0.01

    def sample_trials(self, key: Any, num: int, roughness: float | None = None) -> Trials:
        return Trials(jax.random.uniform(key, (num, 1)))

    def fitness(self, state: Sliding) -> Any:
        return state.qpos[0]

    def reset(self, given: Trial) -> Sliding:
        return Sliding(jnp.zeros(1), jnp.zeros(()), TrialState.begin())

    def observe(self, state: Sliding) -> Any:
        return state.speed

    def step(self, state: Sliding, action: Any, given: Trial) -> Sliding:
        height = given.ground.heights[given.ground.row, 0]
        speed = state.speed + self.timestep * (action - height)
        steps = state.trial.num_steps + 1
        trial = state.trial._replace(num_steps=steps, done=steps >= 50)
        return Sliding(state.qpos + self.timestep * speed, speed, trial)


@dataclasses.dataclass(frozen=True)
class Push(Controller):
    """Pushes as hard as its only weight says, less as it becomes faster."""

    def template(self) -> Any:
        return jnp.zeros(())

    def act(self, genotype: Any, memory: Any, observation: Any, /) -> tuple[Any, Any]:
        return memory, genotype - 0.1 * observation


@dataclasses.dataclass(frozen=True)
class Task:
    """The trials of both."""

    def rollout(self, genotype: Any, given: Trial) -> Outcome:
        return rollout(Slope(), Push(), genotype, given)


PUSHES = np.array([1.0, 2.0, 3.0], np.float32)
TRIALS = Trials(np.array([[0.0], [0.5]], np.float32))
GIVEN = TRIALS.given(np.array([0, 1, 0], np.int32))


@pytest.fixture(autouse=True)
def plain(monkeypatch: Any) -> None:
    """Registers the engine for the time of a test."""
    monkeypatch.setattr(registry, "_registered", {})
    engines.register("plain", Plain())


def test_registered_engine_evaluates_as_ours_do() -> None:
    evaluator = evaluation.make_evaluator(Task(), "plain")
    assert (evaluator.engine, evaluator.devices) == ("plain", "whatever JAX takes")
    evaluator.prepare(PUSHES, TRIALS)
    assert evaluator.compile_s == 1.0
    ours = evaluator.evaluate(PUSHES, TRIALS)
    assert ours.distance.shape == (3, 2) and (ours.distance[:, 0] > ours.distance[:, 1]).all()
    for engine in ("lanes", "lanes-xla", "mjx"):
        other = evaluation.make_evaluator(Task(), engine).evaluate(PUSHES, TRIALS)
        jax.tree.map(lambda x, y: np.testing.assert_allclose(x, y, rtol=1e-5), ours, other)


def test_registered_engine_replays_as_ours_do() -> None:
    recordings = [
        replay.record(Slope(), Push(), PUSHES, GIVEN, duration=0.3, engine=engine)
        for engine in ("plain", "lanes", "lanes-xla", "mjx")
    ]
    for other in recordings[1:]:
        jax.tree.map(lambda x, y: np.testing.assert_allclose(x, y, rtol=1e-5), recordings[0], other)


def test_taken_name_is_refused() -> None:
    for name in ("plain", "lanes", "auto"):
        with pytest.raises(ValueError, match=f"there is an engine named '{name}'"):
            engines.register(name, Plain())


def test_unknown_engine_is_refused_with_all_names() -> None:
    known = "auto, lanes, lanes-xla, mjx, plain"
    with pytest.raises(ValueError, match=f"engine must be one of {known}, got 'warp'"):
        engines.choose("warp")


@pytest.mark.parametrize("name", ["lanes", "lanes-xla", "mjx"])
def test_preparing_compiles_for_the_call_that_follows(name: str) -> None:
    mapped = engines.load(name).vmap(lambda x, table: jnp.sin(x) + table[0], (0, None))
    assert mapped.compile_s == 0.0
    mapped.prepare(jax.ShapeDtypeStruct((5,), np.float32), jax.ShapeDtypeStruct((3,), np.float32))
    compiled = mapped.compile_s
    assert compiled > 0.0
    got = mapped(np.ones(5, np.float32), np.ones(3, np.float32))
    np.testing.assert_allclose(got, np.full(5, np.sin(1.0) + 1.0), rtol=1e-5)
    assert mapped.compile_s == compiled
