"""Films a walker: mp4 by ffmpeg, gif by Pillow."""

import contextlib
import dataclasses
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jax
import numpy as np
from jaxtyping import UInt8

from mjxwalk import budget, installing, outputs, replay
from mjxwalk.envs import Terrain
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.errors import RunError
from mjxwalk.pictures import camera, offscreen, scene
from mjxwalk.runs import files

ENDINGS = {".mp4": 50.0, ".gif": 25.0}  # frames a second; gifs count in hundredths of a second
FOLLOW = 0.02  # of the way to the hip's height that the camera goes in a frame; ours
Picture = UInt8[np.ndarray, "down across 3"]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Shot:
    """A walker's trial to be shown.

    Attributes:
      experiment: whose body, controller and ground it has, as they are.
      genotype: of the walker.
      terrain_seed: of the random ground.
      seconds: after which it ends.
    """

    experiment: Any
    genotype: Any
    terrain_seed: int = 0
    seconds: float = 10.0

    def walk(self, frames_per_second: float) -> tuple[Any, Terrain]:
        """Returns the coordinates in each frame, and the ground."""
        env = self.experiment.env
        key = jax.random.key(self.terrain_seed)
        trials = self.experiment.sample_trials(key, 1)
        recording = replay.record(
            env,
            self.experiment.controller,
            jax.tree.map(lambda leaf: np.asarray(leaf)[None], self.genotype),
            trials.given(np.zeros(1, np.int32)),
            duration=min(self.seconds, env.max_time),
            frames_per_second=frames_per_second,
        )
        return np.asarray(recording.states.qpos[:, 0], np.float64), trials.given(0).ground


def check(path: Path) -> None:
    """Returns if a film can be made and written; quick, as nothing is drawn yet.

    Raises:
      RunError: it cannot.
    """
    if path.suffix.lower() not in ENDINGS:
        raise RunError(f"--video must end in {' or '.join(ENDINGS)}, got {path}")
    outputs.check(path, "--video")
    if path.suffix.lower() == ".mp4":
        installing.load("imageio_ffmpeg", "video", "a video as mp4")
    offscreen.library()


def film(shot: Shot, path: Path, *, size: tuple[int, int] = (960, 540)) -> None:
    """Writes a film; an old one is replaced.

    Args:
      shot: what to film.
      path: of the file; its ending says which kind.
      size: pixels across and down, even numbers.

    Raises:
      RunError: there is no OpenGL, or the file cannot be written.
    """
    check(path)
    frames_per_second = ENDINGS[path.suffix.lower()]
    pictures = draw(shot, frames_per_second, size)
    write = _write_gif if path.suffix.lower() == ".gif" else _write_mp4
    try:
        # Elsewhere first: ffmpeg goes back in what it writes, which a pipe does not.
        with tempfile.TemporaryDirectory(prefix="mjxwalk-") as place:
            unfinished = Path(place, f"film{path.suffix.lower()}")
            write(unfinished, pictures, frames_per_second, size)
            content = unfinished.read_bytes()
    except OSError as error:
        raise RunError(f"{path} could not be written: {files.describe(error)}") from None
    outputs.write(path, content)


def draw(shot: Shot, frames_per_second: float, size: tuple[int, int]) -> Iterator[Picture]:
    """Yields the pictures."""
    env = shot.experiment.env
    qpos, ground = shot.walk(frames_per_second)
    model = scene.build(env, ground, qpos, size)
    data = mujoco.MjData(model)
    view = camera.beside(env, model)
    torso = model.body(env.anatomy.torso).id
    height = None
    with offscreen.Painter(model, size) as painter:
        for positions in scene.joint_positions(env, qpos):
            data.qpos[:] = positions
            mujoco.mj_forward(model, data)
            hip = data.xpos[torso]
            # Along with the hip, but not up and down with every step.
            height = hip[2] if height is None else height + FOLLOW * (hip[2] - height)
            view.lookat[:] = hip[0], hip[1], height
            yield painter.draw(data, view)


def _write_mp4(
    path: Path, pictures: Iterator[Picture], frames_per_second: float, size: tuple[int, int]
) -> None:
    library = installing.load("imageio_ffmpeg", "video", "a video as mp4")
    writer = library.write_frames(
        str(path),
        size,
        fps=frames_per_second,
        codec="libx264",
        pix_fmt_out="yuv420p",  # what browsers and phones play
        macro_block_size=2,
        output_params=["-movflags", "+faststart"],
        ffmpeg_log_level="error",
    )
    with contextlib.closing(writer):
        with warnings.catch_warnings():
            # The library forks to start ffmpeg at once, which needs none of JAX's threads.
            warnings.filterwarnings("ignore", message=r".*os\.fork\(\)|.*use of fork\(\)")
            writer.send(None)
        for picture in pictures:
            writer.send(np.ascontiguousarray(picture))


def _write_gif(
    path: Path, pictures: Iterator[Picture], frames_per_second: float, size: tuple[int, int]
) -> None:
    from PIL import Image

    del size  # the pictures have it
    drawn: list[Any] = []
    for picture in pictures:
        # Pillow writes a gif whole; a byte a pixel, and once more as it is written.
        room = 2 * picture.size // 3 * (len(drawn) + 1)
        budget.check(room, f"{len(drawn) + 1:,} pictures of a gif take", "film fewer seconds")
        drawn.append(Image.fromarray(picture).quantize(128))
    first, *others = drawn
    milliseconds = round(1000 / frames_per_second)
    first.save(path, save_all=True, append_images=others, duration=milliseconds, loop=0)
