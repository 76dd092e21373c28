"""Files that `mjxwalk new` writes: each is an example that evolves as it is."""

from pathlib import Path

KINDS = {
    "task": "an environment of your own, with its physics and its fitness",
    "controller": "a controller of your own, for a body that ships",
    "strategy": "a strategy of your own, for a walker of ours",
}


def text(kind: str) -> str:
    """Returns the example of a kind, one of `KINDS`."""
    return Path(__file__).with_name(f"{kind}.py").read_text(encoding="utf-8")
