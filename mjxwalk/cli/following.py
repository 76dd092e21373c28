"""Flags of commands that evolve, for those who look on."""

import dataclasses
import importlib.util
from typing import TYPE_CHECKING

from mjxwalk import installing
from mjxwalk.errors import RunError

if TYPE_CHECKING:
    from mjxwalk.progress import Progress


@dataclasses.dataclass(frozen=True, kw_only=True)
class Following:
    """How a run is looked at while it goes on.

    Attributes:
      live: serve a page on localhost, on which the best walker walks, anew each generation.
      tensorboard: write each generation's figures for TensorBoard too, in RUN/tensorboard.
    """

    live: bool = False
    tensorboard: bool = False

    def check_following(self) -> None:
        """Finds out whether what is asked for is installed.

        Raises:
          RunError: it is not.
        """
        if self.tensorboard and importlib.util.find_spec("tensorboardX") is None:
            raise RunError(
                "--tensorboard needs tensorboardX, which is not installed; add it with: "
                f"{installing.of_extra('tensorboard')}"
            )

    def followed(self, progress: "Progress") -> "Progress":
        """Returns the progress with all that is asked for around it."""
        if self.tensorboard:
            from mjxwalk.watch.tensorboard import TensorBoard

            progress = TensorBoard(progress)
        if self.live:
            from mjxwalk.watch.live import Live

            progress = Live(progress)
        return progress
