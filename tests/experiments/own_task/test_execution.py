"""A user's file makes one experiment, or a sentence says why not."""

from pathlib import Path

import own_tasks
import pytest
from own_tasks import TEXT, changed

from mjxwalk import strategies
from mjxwalk.envs import FlatEnv
from mjxwalk.errors import RunError
from mjxwalk.experiments import own_task
from mjxwalk.experiments.own_task import naming
from mjxwalk.experiments.own_task.examples import text as example

WRONG = {
    "syntax": (
        changed("class State(NamedTuple):", "class State(NamedTuple:"),
        r"\.py:\d+: the syntax",
    ),
    "name": (TEXT + "\nx = jpn\n", "NameError: name 'jpn' is not defined"),
    "import": (changed("import FlatEnv", "import FlatEnvv"), "cannot import name 'FlatEnvv'"),
    "module": ("import not_there\n", ":1: ModuleNotFoundError"),
    "attribute": ("import jax\n\njax.nothing\n", ":3: AttributeError"),
    "exit": (TEXT + "\nraise SystemExit\n", "sys.exit ends the file"),
    "none": ("x = 1\n", "makes no Experiment; write NAME = Experiment"),
    "several": (TEXT + "\nSLOW = dataclasses.replace(TASK, name='slow')\n", "TASK, SLOW; name one"),
    "no name": (changed('name="hopper"', 'name="a hopper"'), "letters, digits, dots"),
    "bad setting": (changed("population_size=64", "population_size=0"), "population_size must be"),
    "abstract": (changed("def observe(", "def observed("), "abstract method '?observe"),
}


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:  # pyright: ignore
    own_tasks.be("me", tmp_path, monkeypatch)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("kind", WRONG)
def test_a_file_that_makes_no_experiment_is_one_sentence(kind: str) -> None:
    text, words = WRONG[kind]
    Path("mine.py").write_text(text, encoding="utf-8")
    with pytest.raises(RunError, match=words) as refused:
        own_task.of_user("mine.py")
    assert str(refused.value).startswith("mine.py") and "\n" not in str(refused.value)


def test_an_experiment_is_found_by_file_by_name_and_by_module() -> None:
    Path("mine.py").write_text(TEXT, encoding="utf-8")
    found = [own_task.of_user(asked) for asked in ("mine.py", "mine.py:TASK", "mine:TASK")]
    assert all(each.experiment is found[0].experiment for each in found)
    assert isinstance(found[0].experiment.env, FlatEnv) and found[0].code.name == "TASK"
    with pytest.raises(RunError, match="makes no TUSK; did you mean TASK"):
        own_task.of_user("mine:TUSK")
    with pytest.raises(RunError, match="hopper must be an Experiment, got Hopper"):
        Path("mine.py").write_text(TEXT + "\nhopper = Hopper()\n", encoding="utf-8")
        own_task.of_user("mine.py:hopper")


def test_an_imported_experiment_is_not_the_files_own() -> None:
    Path("mine.py").write_text(
        "import dataclasses\n\nfrom mjxwalk.experiments.solomon import PLANAR_LPD\n\n"
        'MINE = dataclasses.replace(PLANAR_LPD, name="mine")\n',
        encoding="utf-8",
    )
    assert own_task.of_user("mine.py").code.name == "MINE"


def test_what_it_imports_from_its_folder_is_named() -> None:
    Path("beside_the_task.py").write_text("SIGMA = 0.5\n", encoding="utf-8")
    text = changed('"sigma": 0.5', '"sigma": SIGMA').replace(
        "import dataclasses\n", "import dataclasses\n\nfrom beside_the_task import SIGMA\n", 1
    )
    Path("mine.py").write_text(text, encoding="utf-8")
    assert own_task.of_user("mine.py").beside == ("beside_the_task.py",)


def test_of_two_tasks_the_one_that_evolves_has_the_name_of_its_strategy(tmp_path: Path) -> None:
    mine, other = example("strategy"), example("strategy") + "\n# another text\n"
    Path("mine.py").write_text(mine, encoding="utf-8")
    task = own_task.of_user("mine.py")
    ours = strategies.FACTORIES["my-climber"]
    Path("task.py").write_text(other, encoding="utf-8")
    text = naming.read(Path("task.py"))
    code = type(task.code)(file="other.py", name="TASK", sha256=text.sha256)
    own_task.trust.trust(text.sha256, "other.py")
    own_task.of_run(tmp_path, code)
    assert strategies.FACTORIES["my-climber"] is ours
    own_task.of_run(tmp_path, code, is_main=True)
    assert strategies.FACTORIES["my-climber"] is not ours
