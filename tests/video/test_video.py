"""Tests of films: their frames change, and where they cannot be made a sentence says why."""

import os
import re
import sys
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from PIL import Image

from mjxwalk import cli, video, walkers
from mjxwalk.envs import Flame, Planar7
from mjxwalk.errors import RunError
from mjxwalk.pictures import offscreen, scene
from mjxwalk.player import page
from mjxwalk.video import filming

SIZE = (160, 120)


@pytest.fixture(scope="module", autouse=True)
def drawable() -> None:
    """Skips where nothing can be drawn."""
    try:
        offscreen.library()
    except RunError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def walked() -> Any:
    """Returns a second and a half of the planar walker of the zoo, walked once."""
    walker = walkers.best("zoo:planar-lpd")
    shot = video.Shot(
        experiment=walker.experiment.as_tested(), genotype=walker.genotype, seconds=1.5
    )
    return shot, shot.walk(25.0)


@pytest.fixture
def shot(walked: Any, monkeypatch: pytest.MonkeyPatch) -> video.Shot:
    made, result = walked

    def walk(self: Any, frames_per_second: float) -> Any:
        return result

    monkeypatch.setattr(video.Shot, "walk", walk)
    return made


def apart(one: Any, other: Any) -> float:
    """Returns the share of pixels that differ by more than compression makes them."""
    difference = np.abs(np.asarray(one, int) - np.asarray(other, int)).max(axis=-1)
    return float(np.mean(difference > 30))


def test_frames_of_a_film_change(shot: video.Shot, tmp_path: Path) -> None:
    path = tmp_path / "a.mp4"
    video.film(shot, path, size=SIZE)
    reader: Any = imageio_ffmpeg.read_frames(str(path))
    told = next(reader)
    assert (told["size"], told["fps"]) == (SIZE, 50.0)
    frames = [np.frombuffer(frame, np.uint8).reshape(120, 160, 3) for frame in reader]
    assert 36 <= len(frames) <= 40
    assert apart(frames[5], frames[20]) > 0.02 and apart(frames[20], frames[35]) > 0.02
    assert [each.name for each in tmp_path.iterdir()] == ["a.mp4"]


def test_frames_of_a_gif_change(shot: video.Shot, tmp_path: Path) -> None:
    path = tmp_path / "a.gif"
    video.film(shot, path, size=SIZE)
    with Image.open(path) as film:
        assert film.size == SIZE and getattr(film, "n_frames") > 30  # noqa: B009 not in its types
        film.seek(5)
        early = np.asarray(film.convert("RGB"))
        film.seek(25)
        assert apart(early, film.convert("RGB")) > 0.02


def test_pictures_show_the_walker_and_its_ground(shot: video.Shot) -> None:
    picture = next(iter(filming.draw(shot, 25.0, SIZE)))
    red, green, blue = (picture[..., place].astype(int) for place in range(3))
    legs = (blue > red + 40), (red > blue + 40) & (red > green + 20)
    for side in legs:  # the left leg is blue, the right one orange
        rows, columns = np.nonzero(side)
        assert len(rows) > 30
        assert abs(columns.mean() - 80) < 30  # the camera follows
    sky, ground = picture[:20].mean(axis=(0, 1)), picture[-8:].mean(axis=(0, 1))
    assert sky[2] > sky[0]  # bluish
    assert ground[0] >= ground[2]  # not so


@pytest.mark.parametrize("env", [Planar7(), Flame()], ids=["planar", "spatial"])
def test_legs_have_the_colours_of_the_pages(env: Any) -> None:
    style = (Path(page.__file__).parent / "bundle" / "watch.css").read_text()
    ground: Any = env.sample_trials(jax.random.key(0), 1).given(0).ground
    model = scene.build(env, ground, np.zeros((1, 15)), SIZE)
    for side in ("left", "right"):
        found = re.search(rf"--{side}: #(\w{{6}})", style)
        assert found is not None
        expected = [value / 255 for value in bytes.fromhex(found[1])]
        for link in ("thigh", "shank", "foot"):
            geoms = np.flatnonzero(model.geom_bodyid == model.body(f"{link}_{side}").id)
            assert len(geoms)
            for geom in geoms:
                np.testing.assert_allclose(model.geom_rgba[geom, :3], expected, atol=0.003)


def test_the_spatial_body_stands_on_its_ground() -> None:
    env = Flame()
    ground: Any = env.sample_trials(jax.random.key(0), 1).given(0).ground
    model = scene.build(env, ground, np.zeros((1, 15)), SIZE)
    field = model.hfield_data.reshape(model.hfield_nrow[0], model.hfield_ncol[0])
    geom = model.geom("ground")
    size = model.hfield_size[0]
    found = geom.pos[2] + size[2] * field
    across = np.linspace(-size[1], size[1], len(found)) + geom.pos[1]
    along = np.linspace(-size[0], size[0], found.shape[1]) + geom.pos[0]
    row, column = len(found) // 3, found.shape[1] // 2
    expected = env.terrain.height(ground, jnp.float32(along[column]), jnp.float32(across[row]))
    # Heights as float32 of the relief.
    assert found[row, column] == pytest.approx(float(expected), abs=1e-4)


@pytest.mark.parametrize(
    ("path", "complaint"),
    [
        ("a.avi", "--video must end in .mp4 or .gif, got a.avi"),
        ("no/a.mp4", "make no first"),
        ("folder.gif", "is a folder"),
    ],
)
def test_a_wrong_path_is_one_sentence(
    path: str, complaint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("folder.gif").mkdir()
    with pytest.raises(RunError, match=complaint):
        video.check(Path(path))


def test_without_ffmpeg_the_extra_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(RunError, match="pip install 'imageio-ffmpeg>="):
        video.check(tmp_path / "a.mp4")
    video.check(tmp_path / "a.gif")


def test_without_opengl_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(offscreen, "_works", lambda name: False)
    with pytest.raises(RunError, match="neither EGL nor OSMesa; install one"):
        offscreen.library.__wrapped__()


def test_a_driver_that_fails_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(offscreen, "_works", lambda name: name == "osmesa")
    assert offscreen.library.__wrapped__() == "osmesa"


def test_without_a_screen_the_window_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(RunError, match="--viewer needs a screen"):
        video.check_screen()


def test_watch_writes_a_film_in_place_of_the_page(
    shot: video.Shot,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    film = filming.film
    monkeypatch.setattr(video, "film", lambda shot, path: film(shot, path, size=SIZE))
    assert cli.main(["watch", "zoo:planar-lpd", "--seconds", "1.5", "--video", "a.gif"]) == 0
    assert capsys.readouterr().out == "a.gif\n"
    assert os.listdir() == ["a.gif"]


@pytest.mark.parametrize(
    ("args", "complaint"),
    [
        (["--video", "a.avi"], "--video must end in .mp4 or .gif, got a.avi"),
        (["--video", "a.gif", "--champions", "2"], "--video shows one walker; leave out"),
        (["--video", "a.gif", "--out", "a.html"], "--video takes the place of the page"),
        (["--viewer", "--open"], "--viewer takes the place of the page"),
        (["--viewer"], "--viewer needs a screen"),
    ],
)
def test_wrong_wishes_are_one_sentence(
    args: list[str],
    complaint: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert cli.main(["watch", "zoo:planar-lpd", *args]) == 2
    error = capfd.readouterr().err
    assert complaint in error
    assert re.fullmatch(r"mjxwalk: [^\n]+\n", error)
    assert not os.listdir()
