"""Tests of `--body`: a file of the user's becomes a run that needs the file no more."""

import dataclasses
import os
import re
import shutil
from pathlib import Path

import msgspec
import numpy as np
import pytest

from mjxwalk import experiments, runs
from mjxwalk.cli import main
from mjxwalk.controllers import LinearReactive
from mjxwalk.envs import Planar7
from mjxwalk.envs.bodies import planar7_body
from mjxwalk.experiments import own_body, repeating, run_config
from mjxwalk.runs import config

OURS = planar7_body.MODEL_PATH.read_text()
CHILD = Path(__file__).parents[2] / "docs/bodies/child.xml"


@pytest.fixture(autouse=True)
def in_new_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("args", "complaint"),
    [
        (
            ["--body", "no.xml"],
            "--body no.xml does not exist; a body is an MJCF or URDF file, a run",
        ),
        (["--body", "."], "--body . is a folder, and no run"),
        (["--body", "text.xml"], "text.xml: line 1: it is no XML"),
        (["--body", "bytes.xml"], "--body bytes.xml is no text"),
        (["--body", "wide.xml"], "--body wide.xml is no text; name an MJCF file, as XML in UTF-8"),
        (["--body", "pipe"], "pipe could not be used: it is no plain file"),
        (["--body", "/dev/zero"], "/dev/zero could not be used: it is no plain file"),
        (["solomon-3d", "--body", "ours.xml"], "ours.xml: body torso must have the joints root_x"),
        (["solomon-2d", "--body", "text.xml"], "text.xml: is no XML"),
        (["rayleigh", "--body", "ours.xml"], "rayleigh has no body, which takes no other"),
        (["reil-unassisted", "--body", "ours.xml"], "reil-unassisted has the body Reil"),
        (["--set", "env.body=x"], "env.body goes with settings that belong to it; use --body FILE"),
    ],
)
def test_a_wrong_body_is_one_sentence_and_leaves_nothing(
    args: list[str], complaint: str, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    Path("text.xml").write_text("a walker")
    Path("bytes.xml").write_bytes(b"\xff\xfe\x00")
    Path("ours.xml").write_text(OURS)
    Path("wide.xml").write_text(OURS, "utf-16")
    os.mkfifo("pipe")
    before = sorted(tmp_path.iterdir())
    assert main(["evolve", *args, "--out", "run"]) == 2
    error = capfd.readouterr().err
    assert complaint in error
    assert re.fullmatch(r"mjxwalk: [^\n]+\n", error)
    assert sorted(tmp_path.iterdir()) == before


HOSTILE = {
    "include": '<include file="secret.xml"/>',
    "capitals": '<INCLUDE file="secret.xml"/>',
    "flexcomp": '<flexcomp name="f" type="mesh" dim="2" file="secret.xml"/>',
    "pipe": '<hfield name="h" file="pipe.png" size="1 1 1 1"/>',
    "entity": "&secret;",
    "repeated": '<replicate count="99999"><replicate count="99999"><site/></replicate></replicate>',
    "step": '<option timestep="nan"/>',
}


def hostile(text: str, added: str) -> str:
    """Returns a body with something in it that no body may have."""
    doctype = '<!DOCTYPE mujoco [<!ENTITY secret SYSTEM "secret.xml">]>\n' if "&" in added else ""
    return f"{doctype}{text.replace('<worldbody>', f'{added}<worldbody>')}"


@pytest.fixture
def traps(tmp_path: Path) -> None:
    """Makes what a hostile body may name: a file, and a pipe that nobody writes to."""
    (tmp_path / "secret.xml").write_text(
        "<mujoco><custom><text name='a' data='b'/></custom></mujoco>"
    )
    os.mkfifo(tmp_path / "pipe.png")


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_body_is_one_sentence(
    name: str, traps: None, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("my.xml").write_text(hostile(OURS, HOSTILE[name]))
    assert main(["evolve", "planar-lpd", "--body", "my.xml", "--out", "run"]) == 2
    assert re.fullmatch(r"mjxwalk: my\.xml: line \d+: [^\n]+\n", capfd.readouterr().err)
    assert not Path("run").exists() and not Path("MUJOCO_LOG.TXT").exists()


@pytest.mark.parametrize("name", HOSTILE)
def test_the_body_of_a_strangers_run_passes_the_same_door(
    name: str, traps: None, capfd: pytest.CaptureFixture[str]
) -> None:
    usual = experiments.get("planar-lpd")
    settings = run_config.Config(experiment=own_body.with_body(usual, OURS))
    Path("run").mkdir()
    data = msgspec.json.decode(run_config.text(settings))
    data["experiment"]["env"]["body"] = hostile(OURS, HOSTILE[name])
    del data["digest"], data["schema"]
    data = {"schema": config.WITHOUT_DIGEST, **data}
    Path("run/config.json").write_bytes(msgspec.json.encode(data))
    assert main(["resume", "run"]) == 2
    assert main(["evolve", "--body", "run", "--out", "mine"]) == 2
    first, second = capfd.readouterr().err.splitlines()
    for told in (first, second):
        assert re.fullmatch(r"mjxwalk: run.*: line \d+: .+", told)
    assert [each.name for each in Path("run").iterdir()] == ["config.json"]


def test_our_own_body_changes_no_setting() -> None:
    for name in ("planar-lpd", "solomon-2d/lpd"):
        usual = experiments.get(name)
        same = own_body.with_body(usual, OURS)
        assert isinstance(same.env, Planar7) and same.env.body == OURS
        env = usual.env
        assert isinstance(env, Planar7) and env.weight == same.env.weight
        assert same == dataclasses.replace(usual, env=dataclasses.replace(env, body=OURS))


def test_settings_go_by_weight_and_leg_length() -> None:
    usual = experiments.get("planar-lpd")
    child = own_body.with_body(usual, CHILD.read_text())
    # 12.54 + 1.70 + 2 (2.10 + 0.98 + 0.30) kg on legs of 0.282 + 0.283 + 0.045 m; ours are 70 kg.
    longer, stronger = 0.61 / 0.9275, 21.0 / 70.0 * 0.61 / 0.9275
    assert child.env.weight == pytest.approx(21.0 * 9.81)
    assert isinstance(child.controller, LinearReactive) and isinstance(child.env, Planar7)
    assert child.env.min_hip_height == pytest.approx(0.78 * longer)
    assert child.env.torque_budget == pytest.approx(8_000.0 * stronger)
    assert child.controller.torque_limit == pytest.approx(300.0 * stronger)
    assert child.env.torso_mass == 12.54


@pytest.mark.slow
def test_a_run_with_a_body_goes_on_without_its_file_to_the_same_bits(
    capfd: pytest.CaptureFixture[str],
) -> None:
    small = "--population 16 --set env.max_time=0.5 --seed 3 --engine lanes --keep all".split()
    Path("child.xml").write_bytes(CHILD.read_bytes())
    Path("ours.xml").write_text(OURS)
    bodies = {"plain": [], "ours": ["--body", "ours.xml"], "child": ["--body", "child.xml"]}
    for name, body in bodies.items():
        assert main(["evolve", *small, "--generations", "3", *body, "--out", name]) == 0
    plain, ours, child = (runs.load(name) for name in bodies)
    for name, array in plain.arrays.items():
        np.testing.assert_array_equal(array, ours.arrays[name])
    assert not np.array_equal(plain.fitness, child.fitness)
    again = repeating.command(child, experiments.of_run(child))
    assert "--body child" in again and "env.body" not in again and "torso_mass" not in again
    for file in ("child.xml", "ours.xml"):
        Path(file).unlink()
    shutil.copytree("child", "killed")
    shutil.rmtree("killed/checkpoints/3")
    for left in ("result.json", "champion.npz"):
        Path("killed", left).unlink()
    assert main(["resume", "killed"]) == 0
    for name, array in child.arrays.items():
        np.testing.assert_array_equal(array, runs.load("killed").arrays[name])
    assert main(["evolve", *small, "--generations", "3", "--body", "child", "--out", "same"]) == 0
    for name, array in child.arrays.items():
        np.testing.assert_array_equal(array, runs.load("same").arrays[name])
    assert main(["verify", "child", "--terrains", "2"]) == 0
    assert main(["export", "child", "--to", "mjcf", "--out", "back.xml"]) == 0
    Planar7(body=Path("back.xml").read_text())
    assert main(["watch", "child", "--out", "page.html"]) == 0
    assert capfd.readouterr().err == ""
