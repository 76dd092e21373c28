"""Exports of every policy read back, over the observations of a trial, normalised ones included."""

import dataclasses
import functools
import io
import json
from typing import Any

import jax
import numpy as np
import onnxruntime
import pytest
import safetensors.numpy
from cart import Cart

from mjxwalk import rollout
from mjxwalk.cli import main
from mjxwalk.controllers import (
    Harmonics,
    LinearFeedback,
    Mlp,
    PatternGenerator,
    Policy,
    RecurrentNetwork,
)
from mjxwalk.controllers.normalisation import Normalised
from mjxwalk.envs import MjcfEnv
from mjxwalk.errors import RunError
from mjxwalk.export import contract, controllers, step
from mjxwalk.robots import text
from mjxwalk.runs.trees import flatten, unflatten
from mjxwalk.walker import Walker

STEPS = 60  # of a trial that are compared
BODY, CART = MjcfEnv.of(text("walker2d"), max_time=1.0), Cart(steps=STEPS)
POLICIES: dict[str, Policy] = {
    "linear": LinearFeedback(),
    "mlp": Mlp(hidden=(5, 4)),
    "layer norm": Mlp(hidden=(5,), activation="elu", layer_norm=True),
    "elman": RecurrentNetwork(units=4, cell="elman"),
    "gru": RecurrentNetwork(units=4, cell="gru"),
    "ctrnn": PatternGenerator(),
    "harmonics": Harmonics(),
}
EVERY = [(name, normalise) for name in POLICIES for normalise in (False, True)]


@dataclasses.dataclass(frozen=True)
class Small:
    """What of an experiment an export reads."""

    env: Any
    controller: Any
    name: str = "small"


def made(env: Any, name: str, normalise: bool) -> Walker:
    """Returns a walker with weights all over the place, which knows senses as it never sensed."""
    policy = dataclasses.replace(POLICIES[name], normalise=normalise).on(env)
    draws = np.random.default_rng(3)
    genotype = jax.tree.map(
        lambda leaf: np.float32(leaf + 0.3 * draws.normal(size=leaf.shape)), policy.template()
    )
    if normalise:
        senses = genotype.senses._replace(deviation=np.abs(genotype.senses.deviation) + 0.1)
        senses.deviation[0] = 0.0  # of a sense that never changed
        genotype = genotype._replace(senses=senses)
    return Walker(
        name="a", rank="champion", experiment=Small(env, policy), genotype=genotype, generation=7
    )


@functools.cache
def observations(env: Any) -> list[Any]:
    """Returns what a walker senses over a trial."""
    policy = LinearFeedback().on(env)
    given = env.sample_trials(jax.random.key(0), 1).given(0)
    genotype = policy.template()

    @jax.jit
    def trial(walk: Any) -> Any:
        def advance(walk: Any, _: None) -> Any:
            after = rollout.advance(env, policy, genotype, given, walk)
            return after, env.observe(walk.state)

        return jax.lax.scan(advance, walk, None, length=STEPS)[1]

    seen = jax.tree.map(np.asarray, trial(rollout.start(env, policy, genotype, given)))
    return [jax.tree.map(lambda leaf, at=place: leaf[at], seen) for place in range(STEPS)]


def acted(walker: Walker) -> list[tuple[Any, Any]]:
    """Returns what is sensed at each step of a trial, and what a walker asks for there."""
    env, policy = walker.experiment.env, walker.experiment.controller
    act, found = jax.jit(policy.act), list[Any]()
    memory = policy.init(walker.genotype)
    for seen in observations(env):
        memory, action = act(walker.genotype, memory, seen)
        found.append((seen, action))
    return found


@pytest.mark.parametrize("env", [BODY, CART], ids=["body", "task"])
@pytest.mark.parametrize(("name", "normalise"), EVERY)
def test_onnx_asks_for_what_the_policy_asks(env: Any, name: str, normalise: bool) -> None:
    walker = made(env, name, normalise)
    session: Any = onnxruntime.InferenceSession(controllers.as_onnx(walker))
    told = json.loads(controllers.told(walker))
    assert {each.name for each in session.get_inputs()} == {
        each["name"] for each in (*told["senses"], *told["memory"])
    }
    assert not any("sums" in each["name"] for each in told["memory"])
    outputs = [each.name for each in session.get_outputs()]
    memory = {
        each["name"]: np.array(told["starts"][each["name"]], each["dtype"])
        for each in told["memory"]
    }
    for seen, asked in acted(walker):
        if step.is_task(env):
            senses, expected = {"observation": np.asarray(seen)}, {"action": asked}
        else:
            senses = {name: np.asarray(getattr(seen, name)) for name in step.sensed(env)}
            expected = env.scaled_action(asked)._asdict()
        found = dict(zip(outputs, session.run(outputs, senses | memory), strict=True))
        for part, values in expected.items():
            # Both are float32, whose sums of products differ in the last digit of the largest.
            scale = max(1.0, float(np.abs(values).max()))
            np.testing.assert_allclose(found[part], values, rtol=0, atol=3e-6 * scale)
        memory = {name: found[name.replace("memory.", "next.")] for name in memory}


@pytest.mark.parametrize(("name", "normalise"), EVERY)
def test_weights_read_back_are_a_genotype_that_acts_alike(name: str, normalise: bool) -> None:
    walker = made(BODY, name, normalise)
    with np.load(io.BytesIO(controllers.as_npz(walker))) as file:
        arrays = dict(file)
    read = safetensors.numpy.load(controllers.as_safetensors(walker))
    policy = walker.experiment.controller
    genotype = unflatten(policy.template(), arrays)
    assert isinstance(genotype, Normalised) == normalise
    again = dataclasses.replace(walker, genotype=genotype)
    for (_, asked), (_, expected) in zip(acted(again), acted(walker), strict=True):
        np.testing.assert_array_equal(asked, expected)
    assert all(np.array_equal(read[leaf], arrays[leaf]) for leaf in flatten(walker.genotype))


@pytest.mark.parametrize("normalise", [False, True])
def test_a_linear_policy_of_a_task_follows_from_its_weights_and_their_json(normalise: bool) -> None:
    walker = made(CART, "linear", normalise)
    with np.load(io.BytesIO(controllers.as_npz(walker))) as file:
        arrays = {name.removeprefix("weights."): array for name, array in file.items()}
    told = json.loads(controllers.told(walker))
    assert [each["order"] for each in told["senses"]] == [list(CART.observation_names)]
    assert told["actions"][0]["order"] == ["push"]
    if normalise:
        senses = walker.genotype.senses
        assert told["inputs"][1]["centre"] == pytest.approx(float(senses.mean[1]))
        assert told["inputs"][1]["scale"] == pytest.approx(float(senses.deviation[1]))
        assert [told["inputs"][0][name] for name in ("scale", "limit")] == [1.0, 5.0]
    weights = arrays["weights"] if "weights" in arrays else arrays[""]
    for seen, asked in acted(walker):
        scaled = [
            np.clip((value - each["centre"]) / each["scale"], -limit, limit)
            for value, each in zip(np.asarray(seen, float), told["inputs"], strict=True)
            for limit in [each["limit"] or np.inf]
        ]
        expected = np.clip(weights @ np.array(scaled) + arrays["bias"], -1.0, 1.0)
        np.testing.assert_allclose(asked, expected, atol=1e-6)


def test_memory_of_a_task_is_what_its_policy_remembers() -> None:
    assert step.of(made(CART, "mlp", normalise=True)).memory == {}
    (name,) = step.of(made(CART, "elman", normalise=False)).memory
    assert name.startswith("memory.memory")


def test_an_environment_that_tells_no_names_is_one_sentence() -> None:
    class Nameless:
        """Says nothing."""

    with pytest.raises(RunError, match="Nameless, which does not say what its walkers sense"):
        step.check("a", Small(Nameless(), None))


def test_a_body_of_a_task_is_not_exported(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    walker = made(CART, "mlp", normalise=False)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("mjxwalk.walkers.best", lambda source, **_: walker)
    monkeypatch.setattr("mjxwalk.walkers.check", lambda source, **_: None)
    assert main(["export", "a", "--to", "mjcf", "--out", "a.xml"]) == 2
    assert "has the environment Cart, which says nothing of its body" in capsys.readouterr().err
    assert main(["export", "a", "--to", "onnx", "--out", "a.onnx"]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "a.onnx"]
    assert contract.TASK_LAW in (tmp_path / "a.json").read_text()
