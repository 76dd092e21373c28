"""Films of walkers, rendered by MuJoCo without a screen, and its own window."""

from mjxwalk.video.filming import Shot, check, film
from mjxwalk.video.window import check_screen, view

__all__ = ["Shot", "check", "check_screen", "film", "view"]
