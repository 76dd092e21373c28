"""Tests of `mjxwalk export`: what other programs read is what our walkers do."""

import dataclasses
import io
import json
import re
import sys
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import onnxruntime
import pandas
import pytest
import safetensors.numpy
import toy

from mjxwalk import cli, robots, walkers
from mjxwalk.controllers import CtrnnWalker, LinearReactive, SpatialReactive
from mjxwalk.controllers.harmonics import Harmonics
from mjxwalk.controllers.linear_feedback import LinearFeedback
from mjxwalk.controllers.mlp import Mlp
from mjxwalk.controllers.rayleigh_walker import RayleighWalker
from mjxwalk.controllers.recurrent import PatternGenerator
from mjxwalk.controllers.recurrent_network import RecurrentNetwork
from mjxwalk.envs import Flame, MjcfEnv, Planar7, Reil
from mjxwalk.envs.trees import GRAVITY
from mjxwalk.export import body, contract, controllers, step, sto, trajectory
from mjxwalk.runs.trees import flatten
from mjxwalk.walker import Walker

C_MUJOCO: Any = mujoco
FIL = LinearReactive(links="all")
H1, WALKER2D = (MjcfEnv.of(robots.text(name)) for name in ("h1", "walker2d"))
CASES: dict[str, tuple[Any, Any]] = {
    "torque": (Planar7(), FIL),
    "angle": (Planar7(), dataclasses.replace(FIL, output="angle")),
    "spatial": (Flame(), SpatialReactive(links="all")),
    "oscillators": (Planar7(), RayleighWalker()),
    "neurons": (Reil(), CtrnnWalker(sense=4.0)),
    "numbers": (H1, LinearFeedback(rates=True, period=0.005).on(H1)),
    "numbers in the plane": (WALKER2D, LinearFeedback(moved="all").on(WALKER2D)),
    "perceptron": (WALKER2D, Mlp(hidden=(5,)).on(WALKER2D)),
    "normalised": (WALKER2D, Mlp(hidden=(5,), activation="relu", layer_norm=True).on(WALKER2D)),
    "gated": (WALKER2D, RecurrentNetwork(units=4).on(WALKER2D)),
    "harmonics": (WALKER2D, Harmonics().on(WALKER2D)),
    "generator": (WALKER2D, PatternGenerator().on(WALKER2D)),
}


NUMBERS = ("numbers", "numbers in the plane")


@dataclasses.dataclass(frozen=True)
class Small:
    """What of an experiment an export reads."""

    env: Any
    controller: Any
    name: str = "small"

    def as_tested(self) -> "Small":
        """Returns itself."""
        return self


def made(case: str) -> Walker:
    """Returns a walker with weights all over the place."""
    env, controller = CASES[case]
    draws = np.random.default_rng(3)
    genotype = jax.tree.map(
        lambda leaf: draws.normal(size=leaf.shape).astype(np.float32) * 0.5, controller.template()
    )
    return Walker(
        name="zoo:small",
        rank="winner",
        experiment=Small(env, controller),
        genotype=genotype,
        generation=7,
    )


def seen(env: Any, number: int) -> Any:
    """Returns senses of a walker that moves, contacts in all combinations."""
    draws = np.random.default_rng(number)
    values = {
        name: np.asarray(draws.normal(size=leaf.shape), np.float32)
        for name, leaf in step.sensed(env).items()
    }
    values["time"] = np.asarray(0.1 * number, np.float32)
    values["contact"] = np.array([number % 2 > 0, number % 4 > 1])
    like = step.observation_of(env)
    return like._replace(**{name: jnp.asarray(value) for name, value in values.items()})


@pytest.mark.parametrize("case", list(CASES))
def test_onnx_does_what_the_controller_does(case: str) -> None:
    walker = made(case)
    env, controller = walker.experiment.env, walker.experiment.controller
    session: Any = onnxruntime.InferenceSession(controllers.as_onnx(walker))
    inputs = {each.name for each in session.get_inputs()}
    told = contract.describe(walker, controllers.weights(walker))
    assert inputs == {value.name for value in (*told.senses, *told.memory)}
    act = jax.jit(controller.act)
    memory = controller.init(walker.genotype)
    carried = {name: np.asarray(leaf) for name, leaf in step.of(walker).memory.items()}
    names = [each.name for each in session.get_outputs()]
    for number in range(12):
        observation = seen(env, number)
        memory, action = act(walker.genotype, memory, observation)
        asked: Any = action if isinstance(action, tuple) else env.scaled_action(action)
        given = {name: np.asarray(getattr(observation, name)) for name in step.sensed(env)}
        found = dict(zip(names, session.run(names, given | carried), strict=True))
        for name, expected in asked._asdict().items():
            # Both are float32, whose sums of products differ in the last digit of the largest.
            scale = max(1.0, float(np.abs(expected).max()))
            np.testing.assert_allclose(found[name], expected, rtol=0, atol=1e-6 * scale)
        carried = {name: found[name.replace("memory.", "next.")] for name in carried}
        expected_memory = flatten(memory)
        for name, value in carried.items():
            remembered = expected_memory[name.removeprefix("memory.")]
            # Neurons add up numbers of some tens, over and over.
            error = 1e-6 * (30.0 if case == "neurons" else 1.0)
            np.testing.assert_allclose(value, remembered, rtol=1e-6, atol=error)


def test_weights_and_their_json_are_all_that_a_program_needs() -> None:
    """A linear controller once more, from the two files alone, walking on the left leg."""
    walker = made("torque")
    with np.load(io.BytesIO(controllers.as_npz(walker))) as file:
        weights = dict(file)
    told = json.loads(controllers.told(walker))
    observation = seen(walker.experiment.env, 1)  # the left foot alone touches the ground
    senses: dict[str, float] = {"double stance": 0.0, "bias": 1.0}
    left = dict(zip(told["senses"][3]["order"], observation.angle.ravel(), strict=True))
    left_rate = dict(zip(told["senses"][4]["order"], observation.rate.ravel(), strict=True))
    for angle, end, pitch in (
        (left, "", observation.pitch),
        (left_rate, " rate", observation.pitch_rate),
    ):
        senses |= {
            f"torso{end}": pitch,
            f"stance thigh{end}": angle["hip_left"] - pitch,
            f"inter-leg{end}": angle["hip_right"] - angle["hip_left"],
            f"stance knee{end}": angle["knee_left"],
            f"swing knee{end}": angle["knee_right"],
            f"stance ankle{end}": angle["ankle_left"],
            f"swing ankle{end}": angle["ankle_right"],
        }
    scaled = [(senses[each["name"]] - each["centre"]) / each["scale"] for each in told["inputs"]]
    blend = min(1.0, 0.1 / (0.2 + abs(weights["blend_time"])))
    mixed = (1 - blend) * weights["initiation"] + blend * weights["walking"]
    scales = [each["constants"]["torque_scale"] for each in told["networks"]]
    limit = told["settings"]["torque_limit"]
    output = dict(
        zip(
            [each["name"] for each in told["networks"]],
            np.clip(scales * (mixed @ np.array(scaled)), -limit, limit),
            strict=True,
        )
    )
    expected = {
        "hip_left": output["torso"] - output["inter-leg"],
        "knee_left": output["stance knee"],
        "ankle_left": output["stance ankle"],
        "hip_right": output["inter-leg"],
        "knee_right": output["swing knee"],
        "ankle_right": output["swing ankle"],
    }
    controller = walker.experiment.controller
    _, action = controller.act(walker.genotype, controller.init(walker.genotype), observation)
    order = told["actions"][0]["order"]
    np.testing.assert_allclose(action.torque, [expected[name] for name in order], rtol=1e-4)


def test_weights_that_are_no_links_are_zero() -> None:
    walker = made("torque")
    local = dataclasses.replace(walker.experiment, controller=LinearReactive())
    weights = controllers.weights(dataclasses.replace(walker, experiment=local))
    assert np.count_nonzero(weights["walking"]) == 18


def test_safetensors_hold_the_same_weights_and_the_contract() -> None:
    walker = made("spatial")
    content = controllers.as_safetensors(walker)
    read = safetensors.numpy.load(content)
    for name, array in controllers.weights(walker).items():
        np.testing.assert_array_equal(read[name], array)
    size = int.from_bytes(content[:8], "little")
    metadata = json.loads(content[8 : 8 + size])["__metadata__"]
    assert json.loads(metadata["contract"]) == json.loads(controllers.told(walker))


@pytest.mark.parametrize("case", ["torque", "spatial", "neurons", *NUMBERS])
def test_the_body_compiles_with_the_experiments_numbers(case: str) -> None:
    env, _ = CASES[case]
    if isinstance(env, Planar7):
        env = dataclasses.replace(env, thigh_mass=9.0)
    model = C_MUJOCO.MjModel.from_xml_string(body.as_mjcf(env).decode())
    assert GRAVITY * model.body_subtreemass[0] == pytest.approx(env.weight, rel=1e-6)
    np.testing.assert_allclose(model.body_inertia, env.model.mujoco.body_inertia, rtol=1e-5)
    joints = [model.joint(int(each)).name for each in model.actuator_trnid[:, 0]]
    names = [motor.name for motor in env.anatomy.motors]
    assert [name.replace("adduction_left", "adduction") for name in joints] == names
    assert model.numeric("contact_stiffness").data[0] == env.contact.stiffness


@pytest.fixture(scope="module")
def table() -> sto.Table:
    """Returns half a second of the planar walker of the zoo."""
    take = trajectory.Take(seconds=0.5, frames_per_second=50.0, terrain_seed=0, roughness=None)
    return trajectory.record(walkers.best("zoo:planar-lpd"), take)


def test_sto_and_csv_read_back_equal(table: sto.Table, tmp_path: Path) -> None:
    path = tmp_path / "x.sto"
    path.write_bytes(sto.as_sto(table))
    again = sto.read_sto(path)
    np.testing.assert_array_equal(again.rows, table.rows, strict=True)
    assert (again.title, again.names) == (table.title, table.names)
    # As a program without our reader finds it: below "endheader", separated by tabs.
    lines = path.read_text().splitlines()
    end = lines.index("endheader")
    assert f"nRows={len(table.rows)}" in lines[:end] and "version=1" in lines[:end]
    for read in (
        pandas.read_csv(path, sep="\t", skiprows=end + 1, float_precision="round_trip"),
        pandas.read_csv(io.BytesIO(sto.as_csv(table)), float_precision="round_trip"),
    ):
        assert tuple(read.columns) == table.names
        np.testing.assert_array_equal(read.to_numpy(), table.rows)


def test_a_trajectory_is_that_of_a_body_under_gravity(table: sto.Table) -> None:
    columns = dict(zip(table.names, table.rows.T, strict=True))
    assert len(table.names) == 1 + 9 + 9 + 6 + 12
    np.testing.assert_allclose(columns["time"], 0.02 * np.arange(26), atol=1e-12)
    moved = np.diff(columns["root_x"]) / 0.02
    mean = 0.5 * (columns["root_x_rate"][1:] + columns["root_x_rate"][:-1])
    # Over 20 ms the speed changes by some 0.1 m/s, and not evenly.
    np.testing.assert_allclose(moved, mean, atol=0.05)
    pushing = np.sum(
        [columns[f"{point.name}_force_z"] for point in Planar7().anatomy.points], axis=0
    )
    # The weight, but for the first landing, in which the body is braked.
    assert 0.5 < np.mean(pushing[5:]) / Planar7().weight < 1.6


def test_the_command_writes_the_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["export", "zoo:planar-lpd", "--to", "npz"]) == 0
    files = ["planar-lpd-controller.npz", "planar-lpd-controller.json"]
    assert capsys.readouterr().out.split() == files
    assert json.loads(Path(files[1]).read_text())["walker"] == "zoo:planar-lpd"
    assert cli.main(["export", "zoo:flame-robust", "--to", "mjcf", "--out", "b.xml"]) == 0
    assert C_MUJOCO.MjModel.from_xml_path("b.xml").nu == 7


@pytest.mark.parametrize(
    ("args", "complaint"),
    [
        (["zoo:planar-lpd"], "--to"),
        (["zoo:planar-lpd", "--to", "fbx"], "invalid choice 'fbx'"),
        (["zoo:nobody", "--to", "npz"], "there is no 'nobody' in the zoo"),
        (["nowhere", "--to", "npz"], "nowhere does not exist"),
        (["zoo:planar-lpd", "--to", "npz", "--out", "a.json"], "replaced by the JSON file"),
        (["zoo:planar-lpd", "--to", "npz", "--out", "."], "--out . is a folder"),
        (["zoo:planar-lpd", "--to", "npz", "--out", "taken.npz"], "--out taken.json is a folder"),
        (["zoo:planar-lpd", "--to", "npz", "--out", "no/a.npz"], "make no first"),
        (["zoo:planar-lpd", "--to", "sto", "--seconds", "0"], "--seconds must be from 0.1 to 600"),
        (["zoo:planar-lpd", "--to", "sto", "--frames-per-second", "0"], "must be above 0, got 0.0"),
        (
            ["zoo:planar-lpd", "--to", "csv", "--terrain-seed", "-1"],
            "--terrain-seed must be a whole",
        ),
        (["zoo:planar-lpd", "--to", "csv", "--roughness", "-1"], "--roughness must not be neg"),
        (["toy", "--to", "npz"], "toy is no walker with body and controller to export"),
    ],
)
def test_wrong_input_is_one_sentence(
    args: list[str],
    complaint: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    if args[0] == "toy":
        toy.install(monkeypatch)
        assert cli.main(["evolve", "--generations", "2", "--out", "toy"]) == 0
        capfd.readouterr()
    Path("taken.json").mkdir()
    before = sorted(Path().rglob("*"))
    assert cli.main(["export", *args]) == 2
    error = capfd.readouterr().err
    assert complaint in error
    assert re.fullmatch(r"mjxwalk: [^\n]+\n", error)
    assert sorted(Path().rglob("*")) == before


@pytest.mark.parametrize(("to", "module"), [("onnx", "onnx"), ("safetensors", "safetensors")])
def test_a_missing_package_is_one_sentence_that_says_what_to_install(
    to: str, module: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    assert cli.main(["export", "zoo:planar-lpd", "--to", to, "--out", "/tmp/x"]) == 2
    assert f"{sys.executable} -m pip install '{module}>=" in capfd.readouterr().err


@pytest.mark.parametrize("case", NUMBERS)
def test_linear_feedback_follows_from_its_weights_and_their_json(case: str) -> None:
    """A number for each motor of a row once more, from the two files alone."""
    walker = made(case)
    with np.load(io.BytesIO(controllers.as_npz(walker))) as file:
        weights = dict(file)
    told = json.loads(controllers.told(walker))
    observation = seen(walker.experiment.env, 3)
    found = re.search(r"f = (\S+) \(1 \+ (\S+) tanh", told["roles"])
    assert found is not None
    pace = float(found[1]) * (1 + float(found[2]) * np.tanh(weights["pace"]))
    phase = 2 * np.pi * pace * float(observation.time)
    senses = {"clock's max(sin, 0)": max(np.sin(phase), 0.0), "clock's cos": np.cos(phase)}
    for sense in told["senses"]:
        names = [f"{sense['name']} {part}" for part in sense["order"]]
        values = np.ravel(getattr(observation, sense["name"]))
        senses |= dict(zip(names, values, strict=bool(names)))
    inputs = [(senses[each["name"]] - each["centre"]) / each["scale"] for each in told["inputs"]]
    outputs = np.clip(weights["weights"] @ inputs + weights["bias"], -1.0, 1.0)
    controller = walker.experiment.controller
    _, action = controller.act(walker.genotype, controller.init(walker.genotype), observation)
    numbers = dict(zip(told["actions"][0]["order"], np.asarray(action), strict=True))
    for each, output in zip(told["networks"], outputs, strict=True):
        if "left" in each["name"]:  # of middle ones it is the mean of both sides
            assert numbers[each["name"]] == pytest.approx(output, abs=1e-4)
    assert any("left" in each["name"] for each in told["networks"])
