"""What a folder from anybody must not do: lead elsewhere, block, or pass for another run."""

import os
import re
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

import msgspec
import pytest
import toy
from player import given

from mjxwalk import runs, tournament, walkers
from mjxwalk.cli import main
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.experiments.study_config import StudyConfig
from mjxwalk.runs import (
    RunError,
    checkpoints,
    config,
    digests,
    files,
    folder,
    manifest,
    metrics,
    owner,
    packing,
    result,
)
from mjxwalk.sweep import jobs, plan, run_progress, running
from mjxwalk.tournament import results

SECONDS = 60  # after which something blocks


@pytest.fixture(autouse=True)
def toy_installed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)


@pytest.fixture(autouse=True)
def never_blocked() -> Iterator[None]:
    """Fails a test that waits, for a pipe that nobody writes to, say."""

    def fail(number: int, frame: FrameType | None) -> None:
        raise AssertionError("it blocks")

    before = signal.signal(signal.SIGALRM, fail)
    signal.alarm(SECONDS)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def make(path: Path, seed: int = 0) -> None:
    """Makes a finished run with a tournament."""
    settings = Config(experiment=toy.Toy(), seed=seed, keep=3)
    run_config.create(path, settings)
    manifest.write(path, engine="mjx", why="", devices="", settings={})
    toy.evolve(path, settings)
    toy.hold_tournament(path, StudyConfig(name="toy", phases=(("a", toy.Toy()),)), print)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a folder with two runs of one shape."""
    place = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patch:
        toy.install(patch)
        make(place / "one", seed=1)
        make(place / "two", seed=2)
    return place


@pytest.fixture
def run(made: Path, tmp_path: Path) -> Path:
    """Returns a copy of one of them."""
    shutil.copytree(made / "one", tmp_path / "run")
    return tmp_path / "run"


@pytest.fixture
def outside(tmp_path: Path) -> Path:
    """Returns a folder that nothing may be written to."""
    path = tmp_path / "outside"
    path.mkdir()
    (path / "file").write_text("as it was")
    return path


def state(path: Path) -> dict[str, bytes]:
    return {str(each): each.read_bytes() for each in path.rglob("*") if each.is_file()}


WRITERS: dict[str, Callable[[Path, str], object]] = {
    "replace": lambda place, name: files.replace(place, name, b"new"),
    "create": lambda place, name: files.create(place, name, b"new"),
    "append": lambda place, name: files.append_line(place, name, b"new"),
    "folder": files.make_folder,
}


@pytest.mark.parametrize("writer", list(WRITERS))
@pytest.mark.parametrize("depth", [0, 1, 2])
@pytest.mark.parametrize("leads", ["somewhere", "nowhere"])
def test_nothing_is_written_through_a_link_at_any_depth(
    tmp_path: Path, outside: Path, writer: str, depth: int, leads: str
) -> None:
    place, parts = tmp_path / "place", ["a", "b", "file"]
    place.joinpath(*parts[:depth]).mkdir(parents=True)
    target = outside / ("file" if depth == 2 else "") if leads == "somewhere" else outside / "new"
    place.joinpath(*parts[: depth + 1]).symlink_to(target)
    before = state(outside)
    with pytest.raises((RunError, FileExistsError)):
        WRITERS[writer](place, "a/b/file")
    assert state(outside) == before
    assert sorted(path.name for path in outside.iterdir()) == ["file"]


def test_a_link_at_the_name_of_an_unfinished_file_is_removed_and_not_written_through(
    tmp_path: Path, outside: Path
) -> None:
    (tmp_path / ".file.partial").symlink_to(outside / "file")
    before = state(outside)
    files.replace(tmp_path, "file", b"new")
    assert (tmp_path / "file").read_bytes() == b"new"
    assert state(outside) == before


def test_a_file_with_a_second_name_is_not_added_to(tmp_path: Path, outside: Path) -> None:
    os.link(outside / "file", tmp_path / "log")
    with pytest.raises(RunError, match="has a second name"):
        files.append_line(tmp_path, "log", b"new")
    files.replace(tmp_path, "log", b"new")  # puts another file there
    assert (outside / "file").read_text() == "as it was"


@pytest.mark.parametrize("name", ["../file", "a/../../file", "/tmp/file"])
def test_a_name_that_leads_out_of_the_folder_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "place" / "a").mkdir(parents=True)
    with pytest.raises(RunError, match="leads out of"):
        files.replace(tmp_path / "place", name, b"new")


def test_the_folder_itself_may_be_a_link(run: Path, tmp_path: Path) -> None:
    (tmp_path / "latest").symlink_to("run")
    assert runs.load(tmp_path / "latest").generation == 6
    files.replace(tmp_path / "latest", "new", b"")
    assert (run / "new").exists()


PLACES = [
    "report", "report/runs.csv", "report/.runs.csv.partial", "watch.html", "controller.npz",
    "tensorboard", "checkpoints/6/arrays/0", "checkpoints/.7.partial", "checkpoints", ".lock",
    "metrics.jsonl", "tournament.json", ".winner.npz.partial", "some/where/deep",
]  # fmt: skip


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(
    "command",
    ["report", "watch", "tournament", "resume", "verify", "export --to npz"],
)
def test_a_run_with_a_link_in_it_is_refused_before_any_work(
    run: Path, outside: Path, place: str, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (run / place).parent.mkdir(parents=True, exist_ok=True)
    if (run / place).is_dir():
        shutil.rmtree(run / place)
    (run / place).unlink(missing_ok=True)
    (run / place).symlink_to(outside if "." not in place else outside / "file")
    before = state(outside)
    name, *rest = command.split()
    assert main([name, str(run), *rest]) == 2
    told = capsys.readouterr().err
    assert told.startswith("mjxwalk: ") and told.count("\n") == 1
    assert f"{run / place} is a link" in told
    assert state(outside) == before


def test_a_report_goes_into_no_folder_that_is_a_link(
    tmp_path: Path, outside: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from mjxwalk.report import page

    path = tmp_path / "planar"
    monkeypatch.undo()  # of the toy
    given.make_run(path)
    (path / "report").symlink_to(outside)
    before = state(outside)
    # Behind the look at the whole folder, the door itself.
    with pytest.raises(RunError, match="report is a link"):
        page.prepare(path, "report")
    with pytest.raises(RunError, match="report is a link"):
        files.replace(path, "report/runs.csv", b"")
    assert state(outside) == before


def make_sweep(path: Path) -> None:
    path.mkdir()
    planned = plan.PlannedRun(name="seed-0", args=("toy",))
    data = plan.Plan(runs=(planned,), resources=plan.Resources())
    content = {"schema": plan.SCHEMA, **msgspec.to_builtins(data)}
    (path / plan.FILE).write_bytes(digests.with_digest(content))


@pytest.mark.parametrize("place", ["logs", "logs/seed-0.log", "seed-0", "slurm", "slurm/1.out"])
def test_a_sweep_with_a_link_in_it_is_refused(
    tmp_path: Path, outside: Path, place: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "sweep"
    make_sweep(path)
    (path / place).parent.mkdir(exist_ok=True)
    (path / place).symlink_to(outside / "file" if "." in place else outside)
    before = state(outside)
    assert main(["resume", str(path)]) == 2
    assert f"{path / place} is a link" in capsys.readouterr().err
    if place.startswith("logs"):
        with pytest.raises(RunError, match="is a link"):
            jobs.open_log(path / "logs" / "seed-0.log")
    assert state(outside) == before


def test_a_run_of_a_study_is_no_link(run: Path, tmp_path: Path) -> None:
    study = tmp_path / "study"
    study.mkdir()
    (study / "study.json").write_text("{}")
    (study / "1-a").symlink_to(run)
    with pytest.raises(RunError, match="1-a is a link"):
        folder.check_run(study / "1-a")


FILES = [
    "config.json", "metrics.jsonl", "result.json", "champion.npz", "manifest.json",
    "tournament.json", "winner.npz", "checkpoints/6/arrays/0",
    "checkpoints/6/_CHECKPOINT_METADATA",
]  # fmt: skip


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("kind", ["pipe", "folder", "link"])
def test_what_is_no_plain_file_blocks_no_look_and_is_not_read(
    run: Path, name: str, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (run / name).rename(run.parent / "away")
    if kind == "pipe":
        os.mkfifo(run / name)
    elif kind == "folder":
        (run / name).mkdir()
    else:
        (run / name).symlink_to(run.parent / "away")
    run_progress.read(run)
    main(["list", "--runs", str(run.parent)])
    capsys.readouterr()
    reads: list[Callable[[], object]] = [
        lambda: walkers.best(run),
        lambda: tournament.read(run),
        lambda: metrics.read(run),
        lambda: checkpoints.restore(run / "checkpoints", 6),
    ]
    refused = 0
    for read in reads:
        try:
            read()
        except RunError as error:
            assert "\n" not in str(error)
            refused += 1
    assert refused


def test_a_log_that_is_a_pipe_blocks_no_sweep(tmp_path: Path) -> None:
    (tmp_path / "logs").mkdir()
    log = tmp_path / "logs" / "seed-0.log"
    os.mkfifo(log)
    reason = running.__dict__["_last_line"](log)
    assert reason.startswith("it said nothing")
    with pytest.raises(RunError, match="could not be"):
        jobs.open_log(log)
    os.mkfifo(tmp_path / ".lock")
    assert not folder.is_locked(tmp_path)
    with pytest.raises(RunError, match="it is no plain file"), folder.locked(tmp_path):
        pass


BOUND = ["metrics.jsonl", "result.json", "champion.npz", "manifest.json", "tournament.json",
         "winner.npz", "checkpoints", "checkpoints/6"]  # fmt: skip


@pytest.mark.parametrize("names", [*([each] for each in BOUND), BOUND[1:3], BOUND[4:6]], ids=str)
def test_a_file_of_another_run_of_the_same_shape_is_refused(
    made: Path, run: Path, names: list[str]
) -> None:
    for name in names:
        other, mine = made / "two" / name, run / name
        if other.is_dir():
            shutil.rmtree(mine)
            shutil.copytree(other, mine)
        else:
            shutil.copy(other, mine)
    with pytest.raises(RunError, match="another run|is not the file that its run wrote"):
        walkers.best(run)
        runs.load(run, 6)


def test_every_changed_digit_of_a_tournament_is_found(run: Path) -> None:
    content = (run / results.FILE).read_bytes()
    places = [place for place, byte in enumerate(content) if 48 <= byte < 58]
    assert len(places) > 20
    for place in places:
        changed = bytearray(content)
        changed[place] = 48 + (changed[place] - 47) % 10
        (run / results.FILE).write_bytes(changed)
        with pytest.raises(RunError):
            tournament.read(run)
    (run / results.FILE).write_bytes(content)
    assert tournament.read(run) is not None


def as_older(run: Path) -> None:
    """Makes of a run what the version before wrote: no file named its run."""
    data = msgspec.json.decode((run / config.FILE).read_bytes())
    del data["start"]
    (run / config.FILE).write_bytes(digests.with_digest({**data, "schema": 2}))
    for name in (result.FILE, manifest.FILE):
        data = msgspec.json.decode((run / name).read_bytes())
        for added in (owner.RUN, "weights"):
            data.pop(added, None)
        (run / name).write_bytes(digests.with_digest(data))
    data = msgspec.json.decode((run / results.FILE).read_bytes())
    for added in (owner.RUN, "weights", "digest"):
        del data[added]
    (run / results.FILE).write_bytes(msgspec.json.encode(data))
    lines = (run / metrics.FILE).read_bytes().splitlines()
    plain = [line[: line.index(b',"run"')] + b"}\n" for line in lines]
    (run / metrics.FILE).write_bytes(b"".join(plain))
    for path in (run / "checkpoints").iterdir():
        file = path / "_CHECKPOINT_METADATA"
        data = msgspec.json.decode(file.read_bytes())
        told = data["custom_metadata"]
        index = msgspec.convert(told, packing.Index)
        content = (path / "arrays" / "0").read_bytes()
        digest = packing.digest(index.generation, index.entries, content, None)
        del told["run"]
        told |= {"schema": 2, "digest": digest}
        file.write_bytes(msgspec.json.encode(data))


def test_a_run_of_the_version_before_is_read_and_goes_on(made: Path, run: Path) -> None:
    as_older(run)
    whole, older = runs.load(made / "one"), runs.load(run)
    for one, two in ((whole.arrays, older.arrays), (whole.champion, older.champion)):
        assert {n: a.tobytes() for n, a in one.items()} == {n: a.tobytes() for n, a in two.items()}
    assert older.result == whole.result and older.manifest == whole.manifest
    assert tournament.read(run) == tournament.read(made / "one")
    assert walkers.best(run).rank == "winner"
    for name in (result.FILE, result.CHAMPION_FILE, "checkpoints/6"):
        files.remove(run, name)
    settings = run_config.read(run)
    toy.evolve(run, settings)
    champion = (run / result.CHAMPION_FILE).read_bytes()
    assert champion == (made / "one" / result.CHAMPION_FILE).read_bytes()
    # What it writes now names the run, and is refused in another.
    shutil.copy(made / "two" / result.FILE, run)
    with pytest.raises(RunError, match="another run"):
        result.read(run)


def test_a_file_that_names_no_run_is_refused_in_a_run_of_this_version(run: Path) -> None:
    data = msgspec.json.decode((run / result.FILE).read_bytes())
    del data[owner.RUN]
    (run / result.FILE).write_bytes(digests.with_digest(data))
    with pytest.raises(RunError, match="another run"):
        result.read(run)


@pytest.mark.parametrize("layers", [900, 10**6])
@pytest.mark.parametrize("name", [n for n in FILES if n.endswith(("json", "METADATA", "jsonl"))])
def test_json_of_many_layers_is_one_sentence(
    run: Path, name: str, layers: int, capsys: pytest.CaptureFixture[str]
) -> None:
    deep = b"[" * layers + b"]" * layers
    content = (run / name).read_bytes()
    at = content.index(b"{") + 1
    (run / name).write_bytes(content[:at] + b'"deep":' + deep + b"," + content[at:])
    run_progress.read(run)
    assert main(["list", "--runs", str(run.parent)]) == 0
    capsys.readouterr()
    try:
        walkers.best(run)
        runs.load(run, 6)
    except RunError as error:
        assert "\n" not in str(error)


def test_a_phase_of_another_study_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for seed in ("1", "2"):
        assert main(["evolve", "toys", "--seed", seed, "--out", str(tmp_path / seed)]) == 0
    first = next((tmp_path / "1").glob("1-*"))
    shutil.rmtree(first)
    shutil.copytree(tmp_path / "2" / first.name, first)
    assert main(["resume", str(tmp_path / "1")]) == 2
    assert f"{first} is a run of another study" in capsys.readouterr().err


@pytest.mark.parametrize("value", [[], {}, "x", None, [[[]]], 10**30], ids=str)
def test_a_forged_option_of_the_strategy_is_one_sentence(
    run: Path, value: object, capsys: pytest.CaptureFixture[str]
) -> None:
    data = msgspec.json.decode((run / config.FILE).read_bytes())
    data["experiment"]["strategy"]["options"]["sigma"] = value
    shutil.rmtree(run)
    run.mkdir()
    (run / config.FILE).write_bytes(digests.with_digest(data))
    assert main(["resume", str(run)]) == 2
    told = capsys.readouterr().err
    assert told.startswith("mjxwalk: ") and told.count("\n") == 1


@pytest.mark.parametrize("packages", [[], 5, ["jax"], {"jax": []}], ids=str)
def test_a_forged_manifest_is_one_sentence(run: Path, packages: object) -> None:
    data = msgspec.json.decode((run / manifest.FILE).read_bytes())
    (run / manifest.FILE).write_bytes(digests.with_digest({**data, "packages": packages}))
    with pytest.raises(RunError, match="manifest.json cannot be read"):
        manifest.read(run)


def test_files_are_written_by_three_modules_only() -> None:
    root = Path(runs.__file__).parents[1]
    # The last keeps what this user trusts, in a folder that nobody else can write to.
    allowed = {"outputs.py", "runs/files.py", "data_folder.py"}
    writing = re.compile(
        r"(?<!outputs)\.write_(text|bytes)\(|\bopen\([^)]*[\"'][rb]*[wax+]|O_CREAT|\.savefig\((?!buffer)"
        r"|np\.save|\.tofile\(|\.to_csv\(self|shutil\.(copy|move)|\.(symlink|hardlink)_to\("
    )
    found = {
        os.path.relpath(path, root): match.group()
        for place in (root, root.parent / "scripts")
        for path in place.rglob("*.py")
        if "engines/lanes" not in str(path)  # has a cache, and no file of a run
        for match in writing.finditer(path.read_text())
    }
    lock = found.pop("runs/locking.py")
    assert lock == "O_CREAT"  # of `way.opened`, which follows no link
    assert set(found) == allowed
