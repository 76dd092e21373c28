"""Headless Chromium for tests of pages, with software in place of a graphics card."""

import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--no-sandbox",  # which root cannot have
)
PATIENCE = 120_000  # ms; a busy machine draws a frame in seconds
DESKTOP = {"width": 720, "height": 480}  # small: every pixel is worked out by the CPU
REPLAY = "document.querySelector('.mjxwalk-replay').replay"
PHONE = {"width": 320, "height": 480}


class Opened(NamedTuple):
    """A page, and what went wrong on it so far."""

    page: Any
    complaints: list[str]
    requests: list[str]


def launch() -> Iterator[Any]:
    """Yields a browser; skips the test where there is none."""
    api: Any = pytest.importorskip(
        "playwright.sync_api", reason="pages are tested with: pip install playwright"
    )
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip("pages are tested in Chromium: apt-get install chromium")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        yield browser
        browser.close()


def open_page(browser: Any, path: Path, *, phone: bool = False, **options: Any) -> Opened:
    """Opens a page, from which on all that it complains of or asks the network for is kept."""
    context = browser.new_context(
        viewport=PHONE if phone else DESKTOP, has_touch=phone, is_mobile=phone, **options
    )
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    complaints: list[str] = []
    requests: list[str] = []

    def hear(message: Any) -> None:
        # Chromium itself remarks on reading pixels back from software.
        if message.type in ("error", "warning") and "GPU stall" not in message.text:
            complaints.append(message.text)

    page.on("console", hear)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: requests.append(request.url))
    page.goto(path.resolve().as_uri(), wait_until="commit")
    return Opened(page, complaints, requests)


def wait_ready(page: Any) -> None:
    """Returns when the page's replay is there."""
    wait(page, "replay !== undefined")


def ask(page: Any, what: str) -> Any:
    """Returns what an expression on `replay` is."""
    return page.evaluate(f"(replay => {what})({REPLAY})")


def wait(page: Any, what: str) -> None:
    """Returns when an expression on `replay` is true.

    Playwright's own waiting needs eval, which the page forbids.
    """
    until = time.monotonic() + PATIENCE / 1000
    while not ask(page, what):
        assert time.monotonic() < until, f"{what} did not come true"
        page.wait_for_timeout(50)
