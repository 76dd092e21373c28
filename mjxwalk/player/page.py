"""Writes a show as one HTML file that needs nothing but itself."""

import base64
import functools
import hashlib
from pathlib import Path

import jinja2
import msgspec
from markupsafe import Markup

import mjxwalk
from mjxwalk.player.recording import Show

TEMPLATE = "page.html.jinja"
BUNDLE = Path(__file__).parent / "bundle"  # made by web/build.mjs


def render(show: Show, series: str, *, live: int | None = None) -> str:
    """Returns the HTML; what texts hold is never taken as HTML.

    Args:
      show: what is shown.
      series: its numbers.
      live: number of the recording, of a page that asks its server for those after it.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(TEMPLATE).render(
        show=show,
        data=as_script(show),
        series=Markup(series),
        program=Markup(program()),
        style=Markup(style()),
        policy=f"script-src {script_hash()}" + ("; connect-src 'self'" if live is not None else ""),
        live=live,
        version=mjxwalk.__version__,
    )


def as_script(show: Show) -> Markup:
    """Returns JSON that no text can break out of, inside a script element."""
    text = msgspec.json.encode(show).decode()
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)


@functools.cache
def program() -> str:
    """Returns the page's program, with its licences."""
    return (BUNDLE / "watch.js").read_text(encoding="utf-8")


@functools.cache
def style() -> str:
    """Returns the page's style sheet."""
    return (BUNDLE / "watch.css").read_text(encoding="utf-8")


@functools.cache
def script_hash() -> str:
    """Returns what allows the program, and it alone, in a content security policy."""
    digest = hashlib.sha256(program().encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"
