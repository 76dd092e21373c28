"""What survives of a paper's results, to be put beside ours.

Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and 3D bipedal
walking over rough terrain", Adaptive Behavior 21(1), doi 10.1177/1059712312462904. The bodies of
its tables are lost; these numbers are in its text. What is not here is not known.
"""

from typing import NamedTuple

from mjxwalk.controllers.linear_reactive import NETWORKS


class Quoted(NamedTuple):
    """A published number.

    Attributes:
      value: None where it is lost.
      sd: None where there is none.
      source: where it is published.
    """

    value: float | None
    sd: float | None
    source: str


LOST = Quoted(None, None, "lost")
RUNS = 50  # section 2.7.4, of LPD, FIL and pruning
RSIL_RUNS = 10  # section 2.7.5
VARIANTS: tuple[str, ...] = ("lpd", "fil", "sil", "rsil")

# Table 3's summary, section 3.2: share of non-local links that each network keeps.
RETENTION = dict(zip(NETWORKS, (0.61, 0.51, 0.18, 0.08, 0.66, 0.32), strict=True))
# Section 3.2: non-local links of the reduced set.
REDUCED = dict(zip(NETWORKS, (4, 4, 0, 0, 7, 0), strict=True))
PRUNING_GENERATIONS = Quoted(564, None, "section 3.1; between 353 and 854")

# Of walkers in space.
SPATIAL_FALL_RATE = Quoted(0.117, None, "section 3.5.1, slightly rough")
SPATIAL_COST_OF_TRANSPORT = Quoted(0.376, 0.008, "section 3.5.1, slightly rough")
ROUGH_FALL_RATE = Quoted(0.99, None, "section 3.5.2, on the roughest ground, over this")

# Table 4, and what the text tells of walkers in space.
FALL_RATE: dict[str, Quoted] = {
    "lpd": Quoted(0.073, None, "section 3.3, the best of 50"),
    "fil": LOST,
    "sil": LOST,
    "rsil": LOST,
    "solomon-3d": SPATIAL_FALL_RATE,
    "slight": SPATIAL_FALL_RATE,
    "rough": ROUGH_FALL_RATE,
}
COST_OF_TRANSPORT: dict[str, Quoted] = {
    **dict.fromkeys(VARIANTS, LOST),  # FIL's is a "great improvement", section 3.3
    "solomon-3d": SPATIAL_COST_OF_TRANSPORT,
    "slight": SPATIAL_COST_OF_TRANSPORT,
    "rough": LOST,
}

# Table 5: its numbers are lost, but speed and step length are "generally consistent with a human
# walking at a slightly brisk pace" and double stance is "notably briefer", section 3.4.
HUMAN_IN_PAPER = {
    "double_stance": Quoted(0.20, None, "DeLisa (1998), as cited in section 3.4"),
}

# Fukuchi, Fukuchi & Duarte (2018), PeerJ 6:e4640, data at doi 10.6084/m9.figshare.5722711 (CC BY
# 4.0): 42 adults on the ground at a speed that is comfortable to them.
FUKUCHI = "Fukuchi et al. (2018), 42 adults at comfortable speed"
HUMAN = {
    "speed_m_s": Quoted(1.24, 0.10, FUKUCHI),
    "step_length_m": Quoted(0.65, None, FUKUCHI),
    "double_stance": Quoted(0.204, None, FUKUCHI),
    "stride_time_s": Quoted(2 * 60 / 114.7, None, f"{FUKUCHI}; from 114.7 steps a minute"),
}
