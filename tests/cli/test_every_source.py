"""Every command and script with every walker of the zoo, and with runs of every kind."""

import json
from pathlib import Path
from typing import Any

import pytest
import scripted

from mjxwalk import cli, zoo
from mjxwalk.cli.commands import Command

SCRIPTS = Path(__file__).parents[2] / "scripts"
SHORT = ("--population", "16", "--generations", "2")
RUNS = {
    "fit": ("rayleigh", *SHORT),
    "feet": ("planar-lpd", *SHORT, "--set", "env.max_time=0.5"),
    "hips": ("reil/assisted", *SHORT, "--set", "env.max_time=0.5"),
    "study": ("reil", "--scale", "0.02", *(
        word
        for phase in ("assisted", "unassisted", "steady")
        for setting in ("generations=2", "env.max_time=0.5")
        for word in ("--set", f"{phase}.{setting}")
    )),
}  # fmt: skip
COMMANDS = (
    ("watch", "--out", "page.html"),
    ("verify", "--terrains", "2"),
    ("tournament", "--terrains", "2"),
    ("report", "--trials", "2", "--out", "report"),
    *(
        ("export", "--to", kind, "--seconds", "0.2", "--out", f"exported.{kind}")
        for kind in ("npz", "safetensors", "onnx", "mjcf", "sto", "csv")
    ),
)
OF_SCRIPTS = {
    "angle_density": ("--trials", "2"),
    "champion": ("--out", "weights.npz"),
    "compare_integrators": ("--terrains", "2"),
    "gait_table": ("--trials", "2", "--duration", "0.5"),
    "link_survival": ("--reduced", "reduced.json"),
    "other_grounds": ("--trials", "2"),
    "plot_fitness": (),
    "reil_table": ("--starts", "2"),
    "ship_oscillators": ("--out", "fitted.json"),
    "ship_winner": ("name", "--zoo", "shipped"),
    "spatial_table": ("--terrains", "2"),
    "stick_figures": ("--start", "0"),
}
SOURCES = [
    *(f"zoo:{name}" for name in zoo.names()),
    *(*RUNS, "unfinished", "empty", "file", "nowhere", "zoo:nothing"),
]
pytestmark = pytest.mark.slow


def load(name: str) -> type[Command]:
    """Returns a script's dataclass of arguments."""
    module = scripted.load(name)
    return next(
        value
        for value in vars(module).values()
        if isinstance(value, type) and value.__module__ == name and hasattr(value, "run")
    )


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a folder with a run of every kind."""
    path = tmp_path_factory.mktemp("sources")
    for name, args in RUNS.items():
        assert cli.main(["evolve", *args, "--out", str(path / name)]) == 0
    assert cli.main(["evolve", *RUNS["feet"], "--out", str(path / "unfinished")]) == 0
    (path / "unfinished" / "result.json").unlink()
    (path / "empty").mkdir()
    (path / "file").write_text(json.dumps([]))
    return path


@pytest.fixture(autouse=True)
def inside(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(made)


def check(code: int, args: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """Fails unless it was done, or one sentence says why not."""
    said = capsys.readouterr()
    assert "Traceback" not in said.out + said.err, args
    if code != 0:
        assert code == 2, (args, said.err)
        assert said.err.splitlines()[-1].split(": ")[0] in ("mjxwalk", "script.py"), said.err


@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("command", COMMANDS, ids=lambda words: " ".join(words[:3]))
def test_every_command_works_or_refuses_in_a_sentence(
    command: tuple[str, ...], source: str, capsys: pytest.CaptureFixture[str]
) -> None:
    name, *options = command
    check(cli.main([name, source, *options]), (command, source), capsys)


@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("script", OF_SCRIPTS)
def test_every_script_works_or_refuses_in_a_sentence(
    script: str, source: str, capsys: pytest.CaptureFixture[str]
) -> None:
    args = [source, *OF_SCRIPTS[script]]
    check(cli.run("script.py", load(script), args), (script, source), capsys)
