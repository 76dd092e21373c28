"""Tests that the README says what is so."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def shell_commands() -> list[str]:
    return re.findall(r"```sh\n(.*?)\n```", README, re.DOTALL)


def test_the_checks_run_the_test_command_as_the_readme_has_it() -> None:
    main_job, tests = shell_commands()
    assert main_job.endswith("mjxwalk evolve") and tests.endswith("pytest")
    assert (ROOT / ".ci" / "run").read_text().splitlines().count(tests) == 1


def test_the_library_example_finds_the_optimum() -> None:
    example = re.findall(r"```python\n(.*?)\n```", README, re.DOTALL)[0]
    names: dict[str, object] = {}
    exec(example, names)
    fitness = names["fitness"]
    assert -1e-3 < float(fitness.max()) <= 0  # pyright: ignore


def test_links_lead_to_files() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / target).exists(), target


def test_every_promise_of_security_names_tests_that_exist() -> None:
    promises = (ROOT / "SECURITY.md").read_text().partition("## What is promised")[2]
    promises = promises.partition("## What is trusted")[0]
    paragraphs = [each for each in promises.split("\n\n") if "**" in each]
    assert len(paragraphs) > 9
    for paragraph in paragraphs:
        named = re.findall(r"`(tests/[\w/]+\.py)`", paragraph)
        assert named and all((ROOT / name).is_file() for name in named), paragraph
