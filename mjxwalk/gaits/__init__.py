"""How humans walk: joint angles over a gait cycle, ours or from a user's file; numpy alone.

gait = gaits.adults()
gait = gaits.read(Path("subject.mot"), side="left")
gaits.harmonics(gait.knee, 3)
"""

from mjxwalk.gaits.adults import ADULT_STRIDE_TIME, adults
from mjxwalk.gaits.gait import NUM_POINTS, Gait, Harmonics, evaluate, harmonics
from mjxwalk.gaits.reading import read

__all__ = [
    "ADULT_STRIDE_TIME",
    "NUM_POINTS",
    "Gait",
    "Harmonics",
    "adults",
    "evaluate",
    "harmonics",
    "read",
]
