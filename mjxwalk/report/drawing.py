"""Matplotlib figures as parts of a page: SVG whose colours and letters are the page's own."""

import io
import re

import matplotlib
from markupsafe import Markup, escape
from matplotlib.figure import Figure

from mjxwalk.analysis import figures

# A page in the dark sets these variables; else each colour is as it was drawn.
VARIABLES = {
    figures.NEAR: "--near",
    figures.FAR: "--far",
    figures.GROUND: "--ground",
    figures.MEAN: "--mean",
    **{colour: f"--group-{place}" for place, colour in enumerate(figures.COLOURS) if place > 1},
}
INK = ("#000000", "#262626")
GREY = "#999999"  # matplotlib's 0.6


def inline(figure: Figure, *, name: str, alt: str) -> Markup:
    """Returns a figure as an element of a page.

    Args:
      figure: its parts get colours of the page, and its own background goes.
      name: of the figure; no other on the page may have it.
      alt: what there is to see, for those who cannot.
    """
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        buffer = io.StringIO()
        figure.savefig(buffer, format="svg", transparent=True, metadata={"Date": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", text, flags=re.DOTALL)
    text = re.sub(r'\bd="[^"]*"', _shorter, text)
    text = re.sub(r"(fill|stroke): (#[0-9a-f]{6})", _recoloured, text)
    text = _own_names(text, name)
    return Markup(_opening(text, alt) + text[text.index(">") + 1 :])


def _opening(text: str, alt: str) -> str:
    """Returns the first tag; the page says how large a figure is."""
    found = re.search(r'viewBox="([^"]*)"', text)
    box = found.group(1) if found else "0 0 100 100"
    links = 'xmlns:xlink="http://www.w3.org/1999/xlink"'
    # At the left of its room, where a narrow window shows it.
    place = 'preserveAspectRatio="xMinYMid"'
    return f'<svg viewBox="{box}" {place} {links} role="img" aria-label="{escape(alt)}">'


def _shorter(path: re.Match[str]) -> str:
    """Returns a path's coordinates to the hundredth of a point, half as long."""
    return re.sub(r"(\.\d\d)\d+", r"\1", path.group())


def _recoloured(style: re.Match[str]) -> str:
    kind, colour = style.groups()
    if colour in INK:
        return f"{kind}: currentColor"
    if colour == GREY:
        return f"{kind}: var(--muted)"
    return f"{kind}: var({VARIABLES[colour]}, {colour})" if colour in VARIABLES else style.group()


def _own_names(text: str, name: str) -> str:
    """Returns the drawing with names that no other on the page has, and none that nobody uses."""
    used = set(re.findall(r'(?:xlink:href="#|url\(#)([^")]+)', text))
    text = re.sub(
        r' id="([^"]*)"',
        lambda found: f' id="{name}-{found.group(1)}"' if found.group(1) in used else "",
        text,
    )
    return re.sub(r'(xlink:href="#|url\(#)', rf"\g<1>{name}-", text)
