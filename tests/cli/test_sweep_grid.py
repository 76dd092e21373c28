"""Tests of which runs a sweep has, and what they are asked for."""

from pathlib import Path

import pytest
import toy

from mjxwalk.cli import main
from mjxwalk.cli.evolve import Evolve
from mjxwalk.cli.parsing import parse
from mjxwalk.cli.sweep import Sweep
from mjxwalk.cli.sweep_grid import arguments, grid


@pytest.fixture(autouse=True)
def in_new_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)


def test_every_seed_goes_with_every_combination() -> None:
    asked = Evolve(
        experiment="toy",
        seed=5,
        population=8,
        set=("strategy.sigma=0.1,0.2", "env.friction=1", "goal.some=[1, 2],[3]"),
    )
    runs = grid(asked, 2)
    assert list(runs) == [
        f"sigma-{sigma}-some-{some}-seed-{seed}"
        for sigma in ("0.1", "0.2")
        for some in ("1-2", "3")
        for seed in (5, 6)
    ]
    chosen = runs["sigma-0.2-some-1-2-seed-6"]
    assert chosen.set == ("strategy.sigma=0.2", "env.friction=1", "goal.some=[1, 2]")
    assert (chosen.seed, chosen.population) == (6, 8)


def test_names_tell_settings_apart_that_end_alike() -> None:
    asked = Evolve(experiment="toy", set=("a.rate=1,2", "b.rate=1,2", "text=x y,x-y"))
    names = list(grid(asked, 1))
    assert len(set(names)) == 8
    assert names[0] == "a-rate-1-b-rate-1-text-x-y-seed-0"


@pytest.mark.parametrize(
    "asked",
    [
        Evolve(experiment="toy"),
        Evolve(experiment="toy", seed=3, source="zoo:planar-lpd", keep=None, scale=0.5, terrains=2),
        Evolve(experiment="toy", set=("a.b=1", "c=[1, 2]"), engine="mjx", links=Path("my links")),
        Evolve(
            experiment="toy", tensorboard=True, body=Path("b.xml"), save_every=2, strategy="snes"
        ),
        Evolve(experiment="toy", population=8, roughness=0.5),
    ],
)
def test_arguments_of_a_run_read_back_as_what_was_asked(asked: Evolve) -> None:
    assert parse("mjxwalk evolve", Evolve, arguments(asked)) == asked


def test_the_last_seed_is_the_last(capsys: pytest.CaptureFixture[str]) -> None:
    assert list(grid(Evolve(experiment="toy", seed=2**32 - 2), 2)) == [
        "seed-4294967294",
        "seed-4294967295",
    ]
    assert main(["sweep", "toy", "--seed", str(2**32 - 1), "--seeds", "2", "--out", "s"]) == 2
    assert "go past the last one, 4294967295" in capsys.readouterr().err
    assert not Path("s").exists()


def test_names_are_as_short_as_a_folder_allows() -> None:
    asked = Evolve(experiment="toy", set=tuple(f"a.{n}{'x' * 50}={'1' * 60},2" for n in range(4)))
    names = list(grid(asked, 2))
    assert len(set(names)) == 32
    assert max(map(len, names)) < 240


def test_a_sweep_may_be_gone_on_with_from_another_folder() -> None:
    asked = Sweep(experiment="toy", links=Path("links.json"), source="a", body=Path("b.xml"))
    assert asked.anywhere().links == Path.cwd() / "links.json"
    assert asked.anywhere().body == Path.cwd() / "b.xml"
    assert asked.anywhere().source == str(Path.cwd() / "a")
    assert Sweep(experiment="toy", source="zoo:a").anywhere().source == "zoo:a"
