"""Writes a page as one HTML file, and a CSV file for each of its tables and figures beside it."""

from pathlib import Path

import jinja2

import mjxwalk
from mjxwalk.errors import RunError
from mjxwalk.report.parts import Page
from mjxwalk.runs import files
from mjxwalk.watch import page as watch

FILE = "report.html"
TEMPLATE = "page.html.jinja"


def render(page: Page) -> str:
    """Returns the HTML, which needs nothing but itself; what texts hold is never taken as HTML."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    template = environment.get_template(TEMPLATE)
    return template.render(page=page, version=mjxwalk.__version__, watch=watch)


def prepare(folder: Path) -> None:
    """Makes the folder.

    Raises:
      RunError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"--out {folder} could not be made: {files.describe(error)}") from None


def write(folder: Path, page: Page) -> list[Path]:
    """Writes the files into a folder that is there, and returns their paths, the page first.

    Raises:
      RunError: a file cannot be written, for example because the disk is full.
    """
    html = folder / FILE
    paths = [html]
    for part in page.parts:
        if part.data is not None:
            paths.append(folder / f"{part.name}.csv")
            files.replace(paths[-1], part.data.to_csv(index=False, lineterminator="\n").encode())
    files.replace(html, render(page).encode())
    return paths
