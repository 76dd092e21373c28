"""Tests that no file is read or written in the encoding of whoever's locale."""

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
PLACES = ("mjxwalk", "envs", "strategies", "scripts")
TEXT = ("read_text", "write_text")


def lacking(tree: ast.AST) -> Iterator[int]:
    """Yields the lines of calls that read or write text and name no encoding."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        named = {each.arg: each.value for each in node.keywords}
        called = getattr(node.func, "attr", getattr(node.func, "id", ""))
        modes = [each.value for each in node.args if isinstance(each, ast.Constant)]
        owner = getattr(getattr(node.func, "value", None), "id", "")
        # `outputs` writes UTF-8 always.
        # Processes have text=True; other functions have a text among their arguments.
        is_text = getattr(named.get("text"), "value", False) is True
        is_text |= called in TEXT and owner != "outputs"
        is_text |= called == "TextIOWrapper"
        if called == "open" and isinstance(node.func, ast.Name):
            is_text = not any("b" in str(mode) for mode in modes)
        if is_text and "encoding" not in named:
            yield node.lineno


def test_every_text_has_its_encoding_named() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}"
        for place in PLACES
        for path in (ROOT / place).rglob("*.py")
        for line in lacking(ast.parse(path.read_bytes()))
    ]
    assert found == []


def test_a_text_without_encoding_is_found() -> None:
    assert list(lacking(ast.parse('path.read_text()\nopen("a")\nopen("a", "rb")'))) == [1, 2]
    assert list(lacking(ast.parse("run(words, text=True)\nTask(text=text)"))) == [1]
