"""Writes a page as one HTML file, and a CSV file for each of its tables and figures beside it."""

import os
from pathlib import Path

import jinja2

import mjxwalk
from mjxwalk.errors import RunError
from mjxwalk.player import page as watch
from mjxwalk.report.parts import Page
from mjxwalk.runs import files

FILE = "report.html"
TEMPLATE = "page.html.jinja"
ESCAPED = "backslashreplace"  # names of files may have bytes that are no text


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


def prepare(folder: Path, inside: str = "") -> None:
    """Makes the folder of a page.

    Args:
      folder: that the user named, of the page or of its run.
      inside: folder in it that has the page; "" for none.

    Raises:
      RunError: it cannot be made or written, or is a link in the run's folder.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"--out {folder} could not be made: {files.describe(error)}") from None
    if inside:
        files.make_folder(folder, inside)
    files.check_writable(folder / inside, "; name another folder with --out")


def write(folder: Path, page: Page, inside: str = "") -> list[Path]:
    """Writes the files into a folder that is there, and returns their paths, the page first.

    Args:
      folder: as in `prepare`.
      page: what is written.
      inside: as in `prepare`.

    Raises:
      RunError: a file cannot be written, for example because the disk is full.
    """
    names = [FILE]
    for part in page.parts:
        if part.data is not None:
            names.append(f"{part.name}.csv")
            text = part.data.to_csv(index=False, lineterminator="\n")
            files.replace(folder, os.path.join(inside, names[-1]), text.encode(errors=ESCAPED))
    files.replace(folder, os.path.join(inside, FILE), render(page).encode(errors=ESCAPED))
    return [folder / inside / name for name in names]
