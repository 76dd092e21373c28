"""MuJoCo's own contacts as the law of the ground, in place of penalty forces on points.

The body then touches the ground, and itself, with all geoms that its file lets collide; joint
limits, friction in joints, equality constraints and tendons are MuJoCo's too.
"""

import dataclasses
from typing import Literal

from mjxwalk.envs import checks

MOST_ITERATIONS = 1000  # ours: a step that needs more has no solution


@dataclasses.dataclass(frozen=True, kw_only=True)
class MujocoContact:
    """MuJoCo's contacts and constraints; None stands for what the body's file says.

    Attributes:
      iterations: of the solver, at most; it is Newton's method whatever the file says, since all of
        MuJoCo's solvers have the same solution.
      ls_iterations: on the length of the step that an iteration takes.
      cone: of friction: "pyramidal" or "elliptic".
      integrator: "euler", "implicitfast" or "rk4".
      self_collision: whether parts of the body may touch each other, as far as the file lets them.
    """

    iterations: int | None = None
    ls_iterations: int | None = None
    cone: Literal["pyramidal", "elliptic"] | None = None
    integrator: Literal["euler", "implicitfast", "rk4"] | None = None
    self_collision: bool = True

    def __post_init__(self) -> None:
        for name in ("iterations", "ls_iterations"):
            value = getattr(self, name)
            if value is not None:
                checks.count(self, name)
                if value > MOST_ITERATIONS:
                    raise ValueError(f"{name} must be at most {MOST_ITERATIONS}, got {value}")
        for name, known in (
            ("cone", ("pyramidal", "elliptic")),
            ("integrator", ("euler", "implicitfast", "rk4")),
        ):
            value = getattr(self, name)
            if value is not None and value not in known:
                words = ", ".join(f'"{each}"' for each in known)
                raise ValueError(f'{name} must be one of {words}, got "{value}"')
