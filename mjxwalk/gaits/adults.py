"""The gait of adults that ships with mjxwalk."""

import dataclasses
import functools
from pathlib import Path

from mjxwalk.gaits.gait import Gait
from mjxwalk.gaits.reading import read

DATA = Path(__file__).with_name("fukuchi_2018.csv")
# Not in the data: 120 over the cadence of the same subjects, 114.7 steps a minute.
ADULT_STRIDE_TIME = 1.046  # s


@functools.cache
def adults() -> Gait:
    """Returns how 42 adults walk: Fukuchi, Fukuchi & Duarte (2018), CC BY 4.0.

    PeerJ 6:e4640, data at doi 10.6084/m9.figshare.5722711; `fukuchi_2018.md` says what was changed.
    """
    made = read(DATA)
    return dataclasses.replace(
        made, name="Fukuchi et al. (2018), 42 adults", stride_time=ADULT_STRIDE_TIME
    )
