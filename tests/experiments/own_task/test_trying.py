"""A wrong task is refused before it evolves, in one sentence with the line of the user's file."""

from pathlib import Path

import own_tasks
import pytest
from own_tasks import SMALL, TEXT, changed

from mjxwalk import cli

FELL = "        fell = qpos[1]"
LAST = "return State(qpos, qvel, effort, self.count(state.trial, fell=fell))"
STEP = "    def step("


def before_fall(line: str, beginning: str = "") -> str:
    """Returns the task with a line more in `step`, and one more before its classes."""
    text = changed(FELL, f"        {line}\n{FELL}")
    return text.replace("class State(", f"{beginning}\n\n\nclass State(", 1)


# what is wrong: the file, what the line that is named begins with, words of the sentence
WRONG = {
    "observation": (
        changed("jnp.stack([height - self.leg, ", "jnp.stack([height, height - self.leg, "),
        "    def observe(",
        "4 numbers, as many as observation_names, got float32[5]",
    ),
    "action": (
        changed('("push", "lean")', '("push", "lean", "kick")'),
        "    def act(",
        "an action of 3 numbers",
    ),
    "fitness": (
        changed("return state.qpos[0] - ", "return state.qpos - "),
        "    def fitness(",
        "one number",
    ),
    "shape": (
        changed("State(qpos, qvel, effort, self", "State(qpos, qvel[:1], effort, self"),
        STEP,
        "step changes qvel from float32[2] to float32[1]",
    ),
    "type": (
        changed("State(qpos, qvel, effort, self", "State(qpos, qvel, jnp.asarray(1), self"),
        STEP,
        "step changes effort from float32[] to int32[]",
    ),
    "parts": (changed(LAST, "return qpos, qvel"), STEP, "the same parts as the state"),
    "nothing": (changed(LAST, "pass"), STEP, "step returns nothing"),
    "no trial": (
        changed("jnp.zeros(()), TrialState.begin())", "jnp.zeros(()), None)"),
        "    def reset(",
        "TrialState.begin()",
    ),
    "weights": (
        changed("jnp.zeros((2, 4)), jnp.zeros(2)", "jnp.zeros((2, 4), int), jnp.zeros(2)"),
        "    def template(",
        "arrays of floats",
    ),
    "branch": (before_fall("if qpos[1] < 0: qpos = qpos * 0"), "        if qpos[1]", "jnp.where"),
    "float": (before_fall("low = float(qpos[1])"), "        low = float", "float()"),
    "numpy": (
        before_fall("qpos = np.maximum(np.asarray(qpos), 0.0)", "import numpy as np"),
        "        qpos = np.max",
        "use jax.numpy in its place",
    ),
    "leak": (
        before_fall("SEEN.append(qpos)", "SEEN = []"),
        "        SEEN.",
        "keeps a value in SEEN",
    ),
    "counter": (
        before_fall("COUNTS['steps'] += 1", "COUNTS = {'steps': 0}"),
        "        COUNTS[",
        "side effect",
    ),
    "random": (
        before_fall("qpos = qpos + random.random()", "import random"),
        STEP,
        "something else each time",
    ),
    "setting": (
        before_fall("self.seen = qpos"),
        "        self.seen",
        "a setting cannot be changed",
    ),
    "endless": (
        changed(LAST, LAST.replace("self.count(state.trial, fell=fell)", "state.trial")),
        STEP,
        "has not ended after 2,000 steps",
    ),
    "not a number": (
        changed("return state.qpos[0] - ", "return 0.0 / (0.0 * state.qpos[0]) - "),
        "    def fitness(",
        "not a finite number for any of the first walkers",
    ),
    "no strategy": (changed('name="snes"', 'name="snez"'), "    strategy=", "did you mean snes"),
    "no option": (changed('"sigma"', '"sigmar"'), "    strategy=", "unknown option 'sigmar'"),
    "exception": (
        changed("still = jnp.zeros(2)", 'raise KeyError("leg")'),
        "        raise KeyError",
        "KeyError: 'leg'",
    ),
    "no dataclass": (
        changed("@dataclasses.dataclass(frozen=True, kw_only=True)\nclass Hopper", "class Hopper"),
        STEP,
        "frozen dataclass",
    ),
}


@pytest.fixture(autouse=True)
def _user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:  # pyright: ignore
    own_tasks.be("me", tmp_path, monkeypatch)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_wrong_is_told_with_its_line(
    kind: str, capsys: pytest.CaptureFixture[str], unchecked_types: None
) -> None:
    text, line, words = WRONG[kind]
    file = f"wrong_{kind.replace(' ', '_')}.py"
    Path(file).write_text(text, encoding="utf-8")
    args = ["evolve", file, *SMALL, "--out", "run", "--most-steps", "2000"]
    assert cli.main(args) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"mjxwalk: {file}:{own_tasks.line_of(text, line)}: ")
    assert words in told and told.count("\n") == 1 and "Traceback" not in told
    assert not Path("run").exists()


def test_what_the_engine_cannot_compile_is_told_with_its_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = before_fall("qpos = qpos + 0.0 * jnp.linalg.svd(jnp.outer(qpos, qpos))[1]")
    Path("values.py").write_text(text, encoding="utf-8")
    args = ["evolve", "values.py", *SMALL, "--out", "run", "--engine", "lanes"]
    assert cli.main(args) == 2
    told = capsys.readouterr().err
    assert f"values.py:{own_tasks.line_of(text, 'svd')}" in told and "--engine mjx" in told
    assert told.count("\n") == 1 and not Path("run").exists()


def test_a_print_and_a_cache_are_no_side_effects(capsys: pytest.CaptureFixture[str]) -> None:
    text = before_fall("print('traced'); CACHE['model'] = 1", "CACHE = {}")
    Path("prints.py").write_text(text, encoding="utf-8")
    assert cli.main(["evolve", "prints.py", *SMALL, "--out", "run"]) == 0
    assert "traced" in capsys.readouterr().out


def test_a_setting_of_the_command_line_is_not_blamed_on_a_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("right.py").write_text(TEXT, encoding="utf-8")
    assert cli.main(["evolve", "right.py", "--set", "strategy.sigmar=1", "--out", "run"]) == 2
    assert "unknown option 'sigmar'" in capsys.readouterr().err
