"""Tests of the page in a browser: it opens without complaint, and the walker walks."""

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from player import browser as browsers
from player import given
from player.browser import Opened, ask, wait, wait_ready
from player.given import PLANAR, SPATIAL, made, shown

from mjxwalk import cli
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.player import packing, page
from mjxwalk.report import page as report
from mjxwalk.report.parts import Page, Replay, Section

WEB = Path(__file__).parents[2] / "web"
EVIL = "<script>window.hacked=1</script>"
PARAMS = [PLANAR, SPATIAL]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    yield from browsers.launch()


@pytest.fixture(scope="module", params=PARAMS, ids=["planar", "spatial"])
def source(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(scope="module")
def opened(browser: Any, source: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Opened]:
    """Yields the page of a walker, which plays."""
    path = tmp_path_factory.mktemp("page") / "walker.html"
    found = browsers.open_page(browser, given.write_page(path, source))
    wait_ready(found.page)
    yield found
    found.page.context.close()


def test_the_walker_walks_by_itself_without_complaint(opened: Opened) -> None:
    stage = opened.page.locator(".scene")
    wait(opened.page, "replay.playing && replay.time > 0")
    before, seen = ask(opened.page, "[replay.time, replay.links(0)[0][0]]"), stage.screenshot()
    wait(opened.page, f"replay.time > {before[0]} + 0.2 || replay.time < {before[0]}")
    after = ask(opened.page, "replay.links(0)[0][0]")
    assert abs(after - before[1]) > 0.02  # m
    assert stage.screenshot() != seen
    assert opened.complaints == []
    assert len(opened.requests) == 1  # the page itself, and nothing that it asks for


def test_keys_play_pause_and_scrub(opened: Opened) -> None:
    keyboard, tab = opened.page.keyboard, opened.page
    if ask(tab, "replay.playing"):
        keyboard.press("Space")
    assert not ask(tab, "replay.playing")
    keyboard.press("Home")
    assert ask(tab, "replay.time") == 0
    keyboard.press("ArrowRight")
    assert ask(tab, "replay.time") == pytest.approx(0.1)
    keyboard.press("Shift+ArrowRight")
    assert ask(tab, "replay.time") == pytest.approx(1.1)
    keyboard.press("ArrowLeft")
    keyboard.press(".")
    assert ask(tab, "replay.time") == pytest.approx(1.02)
    keyboard.press("End")
    assert ask(tab, "replay.time") == pytest.approx(3.0)
    keyboard.press("]")
    assert tab.locator("select[aria-label=Speed]").input_value() == "2"
    keyboard.press("[")
    keyboard.press("Space")
    wait(tab, "replay.playing && replay.time < 2.9")  # from the start again
    keyboard.press("Space")
    assert not ask(tab, "replay.playing")
    assert opened.complaints == []


def test_the_bar_scrubs_and_buttons_can_be_pressed(opened: Opened) -> None:
    tab = opened.page
    if ask(tab, "replay.playing"):
        tab.get_by_role("button", name="Pause").click()
    tab.get_by_role("slider", name="Time").click()  # in its middle, once it stands still
    wait(tab, "Math.abs(replay.time - 1.5) < 0.15")
    wait(tab, "document.querySelector('.time').textContent.startsWith('1.')")
    side = tab.get_by_role("button", name="Side")
    side.click()
    assert side.get_attribute("aria-pressed") == "true"
    trail = tab.get_by_role("button", name="Trail")
    trail.click()
    assert trail.get_attribute("aria-pressed") == "false"
    trail.click()
    tab.get_by_role("button", name="Keys and about").click()
    dialog = tab.get_by_role("dialog")
    assert "MIT" in dialog.inner_text() or dialog.locator("pre").count() == 2
    tab.keyboard.press("Escape")
    assert not dialog.is_visible()
    assert opened.complaints == []


def test_links_are_drawn_where_mujoco_has_them(opened: Opened, source: str) -> None:
    tab = opened.page
    if ask(tab, "replay.playing"):
        tab.keyboard.press("Space")
    for _ in range(3):
        tab.keyboard.press("Home")
    tab.keyboard.press("Shift+ArrowRight")
    env = shown(source).experiment.env
    model = env.model.mujoco
    data = mujoco.MjData(model)
    show, series = made(source)
    moves = packing.unpack(show.series, series)["walker 0 moves"][:, 50]
    data.qpos[:] = moves[list(env.anatomy.joint_coordinate)]
    mujoco.mj_kinematics(model, data)
    # The page works in float32, a few metres from its origin.
    np.testing.assert_allclose(ask(tab, "replay.links(0)"), data.xpos[1:], atol=1e-4)


def test_a_report_holds_the_replay(browser: Any, source: str, tmp_path: Path) -> None:
    show, series = made(source)
    replay = Replay(name="replay", show=page.as_script(show), series=series, why="It walked.")
    section = Section(anchor="replay", title="The champion walks", parts=(replay,))
    written = report.render(Page(title=EVIL, lead=(EVIL,), remarks=(), sections=(section,)))
    path = tmp_path / "report.html"
    path.write_text(written)
    opened = browsers.open_page(browser, path)
    tab = opened.page
    wait_ready(tab)
    assert not ask(tab, "replay.playing") and tab.evaluate("window.hacked") is None
    before = ask(tab, "replay.links(0)[0][0]")
    tab.get_by_role("button", name="Play").click()
    wait(tab, "replay.time > 0.3")
    tab.keyboard.press("End")
    assert ask(tab, "replay.links(0)[0][0]") > before + 1.0
    assert opened.complaints == [] and len(opened.requests) == 1
    tab.context.close()


def test_a_report_without_a_replay_lets_nothing_run() -> None:
    written = report.render(Page(title=EVIL, lead=(), remarks=(), sections=()))
    assert "script-src" not in written and "<script" not in written


def test_it_fits_a_phone_and_obeys_who_wants_no_motion(browser: Any, tmp_path: Path) -> None:
    path = given.write_page(tmp_path / "walker.html", PLANAR)
    opened = browsers.open_page(
        browser, path, phone=True, reduced_motion="reduce", color_scheme="dark"
    )
    tab = opened.page
    wait_ready(tab)
    assert not ask(tab, "replay.playing")
    assert tab.evaluate("document.documentElement.scrollWidth <= innerWidth")
    tab.get_by_role("button", name="Play").tap()
    wait(tab, "replay.playing && replay.time > 0")
    assert opened.complaints == []
    tab.context.close()


def test_several_walkers_can_be_chosen(browser: Any, tmp_path: Path) -> None:
    run, path = tmp_path / "run", tmp_path / "several.html"
    given.make_run(run)
    flags = ["--champions", "3", "--seconds", "1", "--out", str(path)]
    assert cli.main(["watch", str(run), *flags]) == 0
    opened = browsers.open_page(browser, path, reduced_motion="reduce")
    tab = opened.page
    wait_ready(tab)
    assert tab.locator(".walkers button").count() == 3
    tab.keyboard.press("ArrowDown")
    assert ask(tab, "replay.walker") == 1
    tab.get_by_role("button", name="generation 3").click()
    assert ask(tab, "replay.walker") == 2
    assert opened.complaints == []
    tab.context.close()


def test_the_name_of_a_folder_does_nothing(browser: Any, tmp_path: Path) -> None:
    run = tmp_path / "<script>window.hacked=1<" / "script><img src=x onerror=window.hacked=2>"
    given.make_run(run)
    assert cli.main(["watch", str(run), "--seconds", "0.5"]) == 0
    opened = browsers.open_page(browser, run / "watch.html", reduced_motion="reduce")
    tab = opened.page
    wait_ready(tab)
    assert tab.locator("h1").inner_text() == str(run)
    assert tab.evaluate("window.hacked") is None
    assert opened.complaints == [] and len(opened.requests) == 1
    tab.context.close()


def test_a_minute_stays_under_five_megabytes(source: str) -> None:
    show, series = made(source)
    rendered = len(page.render(show, series).encode())
    seconds = max(walker.figures.duration_s for walker in show.walkers)
    assert rendered + (60 / seconds - 1) * len(series) < 5e6
    assert 16 * (60 / seconds) * len(series) + rendered < 12e6


def test_the_page_names_the_licences_of_what_it_is_made_of() -> None:
    text = page.render(*made(PLANAR))
    for words in ("three.js authors", "Leon Sorokin", "The MIT License"):
        assert words in text


@pytest.mark.skipif(
    shutil.which("node") is None or not (WEB / "node_modules").is_dir(),
    reason="the bundle is made anew with node, and npm ci in web",
)
def test_the_bundle_is_what_its_sources_make() -> None:
    made_anew = subprocess.run(
        ["node", "build.mjs", "--verify"], cwd=WEB, capture_output=True, text=True, check=False
    )
    assert made_anew.returncode == 0, made_anew.stderr
