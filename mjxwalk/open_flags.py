"""Flags of `os.open` that Windows lacks; there they are 0 and protect from nothing."""

import os

NO_LINK: int = getattr(os, "O_NOFOLLOW", 0)  # refuses a link in the place of the file
NO_WAITING: int = getattr(os, "O_NONBLOCK", 0)  # opens a pipe that nobody writes to
ONLY_FOLDER: int = getattr(os, "O_DIRECTORY", 0)  # refuses what is no folder
NO_TERMINAL: int = getattr(os, "O_NOCTTY", 0)  # makes no terminal this process's own
