"""Every flag of `evolve` with every experiment and study: it begins, or a sentence says why not.

What begins is not evolved, so that the whole matrix takes seconds.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from mjxwalk import cli, experiments, strategies
from mjxwalk.evolution.runner import Runner

# One of every kind; the others take the same ways.
FAST = ("planar-lpd", "reil-unassisted", "rayleigh", "reil", "solomon-2d/rough", "solomon-2d-rsil")
EXPERIMENTS = [
    name if name in FAST else pytest.param(name, marks=pytest.mark.slow)
    for name in (*experiments.names(), *experiments.studies())
]
STUDIES = [
    name if name in FAST else pytest.param(name, marks=pytest.mark.slow)
    for name in experiments.studies()
]
LINKS: dict[str, Any] = {
    "all": {},
    "one.json": {"torso": ["inter-leg"]},
    "unknown.json": {"nothing": ["x"]},
    "list.json": [1],
    "numbers.json": {"torso": [1]},
}
SOURCES = ("zoo:planar-lpd", "zoo:flame-sil", "zoo:reil", "zoo:nothing", "nowhere", ".")
SETTINGS = (
    *("nothing=1", "strategy=null", "env=null", "controller=null", "goal=null", "name=x"),
    *("pruning=null", "pruning.every=3", "ramp=null", "ramp.start=1", "restart_after=5"),
    *("start=winner", "start=population", "test_settings={}", 'test_settings={"x": 1}'),
    *("strategy.sigma=x", "strategy.sigma=-1", "strategy.sigma=[1, 2]", "strategy.name=snes"),
    *("strategy.name=5", "strategy.options=1", "strategy.mask=true", "strategy.links=1"),
    *("strategy.groups=1", "strategy.population_size=4", "population_size=1e3", "generations=0"),
    *("controller.links=all", "controller.links={}", "controller.links=5", "env.max_time=nan"),
    *("env.timestep=0", "env.terrain=null", "weight=1", "gait=nowhere", "network=1"),
    *("=1", "a.b.c=1"),
)


@pytest.fixture(autouse=True)
def begun(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[list[Any]]:
    """Works in a folder of its own, and lets no run be evolved."""
    found: list[Any] = []
    monkeypatch.chdir(tmp_path)
    for name in ("evolve_run", "evolve_study"):
        monkeypatch.setattr(Runner, name, lambda _, path, settings, *__: found.append(settings))
    for name, table in LINKS.items():
        Path(name).write_text(json.dumps(table))
    Path("binary.json").write_bytes(b"\xff\xfe")
    yield found


def check(args: list[str], begun: list[Any], capsys: pytest.CaptureFixture[str]) -> None:
    """Fails unless a run begins, or exactly one sentence says why it does not."""
    begun.clear()
    code = cli.main(args)
    said = capsys.readouterr()
    if code == 0:
        assert len(begun) == 1, args
        return
    assert code == 2, args
    assert said.err.startswith("mjxwalk: ") and said.err.count("\n") == 1, (args, said.err)
    for word in ("Traceback", "Error(", "<class", "<function", "object at 0x", "errno", "NoneType"):
        assert word not in said.err, (args, said.err)
    assert not begun


@pytest.mark.parametrize("experiment", EXPERIMENTS)
def test_every_flag_works_or_is_refused_in_a_sentence(
    experiment: str, begun: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    flags = [
        *(["--links", name] for name in (*LINKS, "binary.json", "nowhere", ".")),
        *(["--from", source] for source in SOURCES),
        *(["--body", path] for path in ("nowhere", ".", "binary.json", "one.json")),
        *(["--strategy", name] for name in (*strategies.FACTORIES, "nothing", "")),
        *(["--scale", text] for text in ("0.01", "1e-9", "1e9", "1e300", "0", "nan", "inf")),
        *(["--roughness", text] for text in ("0.01", "-1", "1e9", "nan", "x")),
        *(["--seed", text] for text in ("-1", str(2**32), "9" * 30, "x")),
        *(["--population", text] for text in ("1", "3", "0", "x")),
        *(["--generations", "1"], ["--terrains", "2"], ["--keep", "all"], ["--save-every", "3"]),
        *(["--set", text] for text in SETTINGS),
        *(["--set", f"{experiment.split('/')[-1]}.{text}"] for text in SETTINGS[:6]),
    ]
    for flag in flags:
        check(["evolve", experiment, *flag, "--out", "new"], begun, capsys)


@pytest.mark.parametrize("study", STUDIES)
def test_every_setting_of_every_phase_works_or_is_refused_in_a_sentence(
    study: str, begun: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    for phase in experiments.phases(study):
        for text in SETTINGS:
            check(["evolve", study, "--set", f"{phase}.{text}", "--out", "new"], begun, capsys)


def test_links_are_for_studies_of_which_a_phase_takes_them_from_a_table(
    begun: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["evolve", "reil", "--links", "one.json", "--out", "new"]) == 2
    assert "no phase of reil takes its links from a table" in capsys.readouterr().err
    assert cli.main(["evolve", "solomon-2d-rsil", "--links", "all", "--out", "new"]) == 0
    links = dict(begun[0].phases)["rsil"].controller.links
    assert links == {}
