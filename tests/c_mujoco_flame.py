"""What tests of the spatial body need to compare it with C MuJoCo."""

import numpy as np
from c_mujoco import Reference, mujoco

__all__ = ["LEFT", "TIE", "Reference", "mujoco"]

LEFT = [*range(6), 6, 7, 8, 9, 10, 12, 13, 14, 15]  # joints whose values are the coordinates
TIE = np.insert(np.eye(15), 11, np.eye(15)[6], axis=0)  # both adductions follow coordinate 6
