"""A walker in MuJoCo's own window."""

import os
import sys
import time
from typing import Any

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.errors import RunError
from mjxwalk.pictures import camera, scene
from mjxwalk.video.filming import Shot

FRAMES_PER_SECOND = 50.0


def check_screen() -> None:
    """Returns if there is a screen to open a window on.

    Raises:
      RunError: there is none.
    """
    if sys.platform == "linux" and not any(
        os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")
    ):
        raise RunError(
            "--viewer needs a screen, and there is none here; write a film with --video FILE.mp4, "
            "or the page without either"
        )


def view(shot: Shot) -> None:
    """Opens the window and shows the trial again and again, until it is closed.

    Raises:
      RunError: there is no screen.
    """
    check_screen()
    import mujoco.viewer as _viewer

    viewer: Any = _viewer
    env = shot.experiment.env
    qpos, ground = shot.walk(FRAMES_PER_SECOND)
    model = scene.build(env, ground, qpos, (640, 480))
    data = mujoco.MjData(model)
    try:
        window = viewer.launch_passive(model, data, show_left_ui=False, show_right_ui=False)
    except RuntimeError as error:  # on macOS, of another Python than MuJoCo's own
        raise RunError(f"MuJoCo's window cannot be opened: {error}") from None
    with window:
        window.cam.type = mujoco.mjtCamera.mjCAMERA_TRACKING
        window.cam.trackbodyid = model.body(env.anatomy.torso).id
        window.cam.azimuth, window.cam.elevation, window.cam.distance = (
            115.0,
            -12.0,
            camera.distance(env),
        )
        while window.is_running():
            started = time.perf_counter()
            for frame, positions in enumerate(scene.joint_positions(env, qpos)):
                data.qpos[:] = positions
                mujoco.mj_forward(model, data)
                window.sync()
                ahead = (frame + 1) / FRAMES_PER_SECOND - (time.perf_counter() - started)
                time.sleep(max(ahead, 0.0))
                if not window.is_running():
                    return
