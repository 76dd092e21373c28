"""What a legged body says of itself: settings, model, start, senses, and what it has of its own."""

import abc
import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Literal, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from mjxwalk.envs import checks, dynamics, motor, targets
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import Anatomy
from mjxwalk.envs.contact import SoftContact
from mjxwalk.envs.course import Course
from mjxwalk.envs.ending import Ending
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.payload import Payload
from mjxwalk.envs.push import Push
from mjxwalk.envs.state import State
from mjxwalk.envs.trees import GRAVITY, FloatingTree, Instant, Loads, PlanarTree, Tree
from mjxwalk.envs.trial import Trial


class Sprung(NamedTuple):
    """Joints with passive springs and dampers; joints are counted from the root's end."""

    joints: Any
    springs: motor.Springs


@dataclasses.dataclass(frozen=True, kw_only=True)
class LeggedBody(abc.ABC):
    """A body, its ground and the rules of a trial.

    Attributes:
      terrain: shape of the random ground.
      course: what lies along the way on top of that; by default nothing.
      push: on the torso, as trials draw them; by default none.
      payload: that the torso carries, as trials draw it; by default nothing.
      contact: law of the ground.
      timestep: of the physics, s.
      integrator: "implicit" takes contact, joint stops, springs and the action's stiffness and
        damping at the end of the step; "explicit" takes all forces at its start. Positions then
        follow the new velocities (semi-implicit Euler).
      max_flight_time: s without ground contact; beyond it the walker has fallen.
      min_speed: the trial ends when the walker is farther behind one of this speed than
        `max_lag`, m/s.
      max_lag: see `min_speed`, m.
      acting: what a policy's numbers from -1 to 1 are: "torque", or "target" of joints about where
        they start, held by stiffness and damping.
      action_noise: standard deviation of normal noise on these numbers, fresh for each action.
      torque_budget: the trial ends when `torque_cost` reaches it, N m s.
      max_time: the trial ends then, s.
    """

    # Largest departures of a start from the usual one where trials draw theirs, to either side, by
    # what departs; in the order of `Trial.start`.
    START_DEPARTURES: ClassVar[Mapping[str, float]] = {}
    # s; of the explicit steps under which winners are tried as well; None where there are none.
    EXPLICIT_TIMESTEP: ClassVar[float | None] = None
    XML_PATH: ClassVar[Path | None] = None  # of the body's file, where it is one of ours

    terrain: Any
    course: Course = Course()
    push: Push = Push()
    payload: Payload = Payload()
    contact: SoftContact
    timestep: float
    integrator: Literal["implicit", "explicit"] = "implicit"
    acting: Literal["target", "torque"] = "torque"
    action_noise: float = 0.0
    max_flight_time: float
    min_speed: float
    max_lag: float
    torque_budget: float
    max_time: float

    def __post_init__(self) -> None:
        checks.positive(self, "timestep", "torque_budget", "max_time")
        checks.not_negative(self, "max_flight_time", "min_speed", "max_lag", "action_noise")
        checks.steps(self)
        checks.one_of(self, "acting", ("target", "torque"))
        if self.integrator not in ("implicit", "explicit"):
            raise ValueError(
                f'integrator must be "implicit" or "explicit", got "{self.integrator}"'
            )
        if self.push and self.push.direction == "sideways" and self.anatomy.root.is_planar:
            raise ValueError(
                f'push.direction must be "forward" or "any", as {self.anatomy.name} moves in a '
                'plane, got "sideways"'
            )

    @property
    @abc.abstractmethod
    def anatomy(self) -> Anatomy:
        """What is known of the body beside its model."""

    @property
    @abc.abstractmethod
    def model(self) -> dynamics.Model:
        """The compiled body, with a joint for each of the root's coordinates."""

    @property
    def floating(self) -> dynamics.Model | None:
        """The same with a free root, of a body in space."""
        return None

    @abc.abstractmethod
    def spec(self) -> Any:
        """Returns the `mujoco.MjSpec` with all of the body that MuJoCo can simulate.

        Beside the tree these are springs, dampers, motors, and joints that are tied.
        """

    @abc.abstractmethod
    def start(self, given: Trial, /) -> State:
        """Returns the state that a trial starts in."""

    @abc.abstractmethod
    def sense(self, state: State, /) -> Any:
        """Returns what the walker senses, a named tuple whose fields the anatomy's senses name.

        It has `contact`, whether each foot touches the ground, and `ankle_x`.
        """

    @property
    @abc.abstractmethod
    def stop_law(self) -> JointStop:
        """Law of the joints' limits, which are the ranges of the anatomy's coordinates."""

    @property
    def springs(self) -> Sprung | None:
        """Passive springs and dampers; None if there are none."""
        return None

    @property
    def friction(self) -> Float[np.ndarray, " joint"] | None:
        """Dry friction of each joint from the root's end on, N m; None if there is none."""
        return None

    @property
    def max_tilt(self) -> dict[str, float]:
        """The root's "yaw", "pitch" and "roll" beyond which the walker has fallen, rad."""
        return {}

    @property
    def lowest_hips(self) -> float | None:
        """Height of the hips over the ground below, under which the walker has fallen, m.

        None where no such rule holds, or another one.
        """
        return None

    def is_low(self, state: State, ground: Float[Array, ""] | float, /) -> Bool[Array, ""]:
        """Returns whether the walker is so low that it has fallen.

        Args:
          state: after the step.
          ground: its height under the hips, m.
        """
        if self.lowest_hips is None:
            return jnp.zeros((), bool)
        return state.qpos[self.anatomy.root.height] - ground < self.lowest_hips

    def low_words(self) -> str:
        """Returns what `is_low` means, for someone who asks why a walker fell."""
        return f"hips lower than {self.lowest_hips:g} m"

    def is_over(self, state: State, /) -> Bool[Array, ""] | bool:
        """Returns whether a rule of the body's own ends the trial without a fall."""
        del state
        return False

    def over_words(self, state: State, /) -> Ending | None:
        """Returns which rule of the body's own ended a trial; None if none did."""
        del state
        return None

    def own_laws(self) -> Mapping[str, tuple[Any, ...]]:
        """Returns, as data, what methods of the body's own do, by the methods' names.

        Whoever computes the body by other means reads it, as `mjxwalk verify` does, which knows the
        laws in `mjxwalk.envs.own_laws`.
        """
        return {}

    def fitness(self, state: State, /) -> Float[Array, ""]:
        """Returns the fitness of a walker whose trial has ended; the distance of its hip, m."""
        return state.qpos[0]

    def ground_height(
        self, given: Trial, x: Float[Array, ""], y: Float[Array, ""] | None = None
    ) -> Float[Array, ""]:
        """Returns the height of a trial's ground at a place, m; y is None in the plane."""
        height = self.terrain.height(given.ground, x, y)
        here = self.course.under(given.ground, x)
        return height if here is None else height + here.height

    def ankles(self, state: State, now: Instant, /) -> Float[Array, " leg"]:
        """Returns how far each ankle is ahead of the hip, m: along x."""
        places = self._tree.bodies(now, self._feet)
        return places[:, 0] if now.axes is None else places @ now.axes[0]

    def carried(self, state: State, now: Instant, given: Trial, /) -> Loads:
        """Returns the loads that the body carries."""
        del state, now, given
        return {}

    def carry_on(self, state: State, moved: State, now: Instant, action: Any, given: Trial) -> Any:
        """Returns what only this body carries, after a step.

        Args:
          state: before the step.
          moved: after it, but for what is returned here.
          now: from `Tree.see` of the state before.
          action: of the step.
          given: the trial.
        """
        del moved, now, action, given
        return state.own

    def scaled_action(self, values: Float[Array, " motor"], /) -> Any:
        """Returns the action of numbers from -1 to 1, one for each motor."""
        anatomy = self.anatomy if self.acting == "torque" else targets.holding(self)
        return motor.scaled(anatomy, values, acting=self.acting)

    @property
    def mass(self) -> float:
        """Of the body without what it carries, kg."""
        return float(self.model.mujoco.body_subtreemass[0])

    @property
    def torso_centre(self) -> Float[np.ndarray, "3"]:
        """The torso's own centre of mass, from its origin in its axes, m."""
        model = self.model.mujoco
        return np.array(model.body_ipos[model.body(self.anatomy.torso).id], np.float32)

    @property
    def weight(self) -> float:
        """Body weight, N."""
        return GRAVITY * float(self.model.mujoco.body_subtreemass[0])

    @property
    def leg_length(self) -> float:
        """From the root to the lowest point of the feet with all joints at zero, m."""
        model = self.model.mujoco
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        return -min(data.site(each.name).xpos[2] - each.radius for each in self.anatomy.points)

    @property
    def walking_time(self) -> float:
        """Of a fall from the height of straight legs, over the square root of two, s."""
        return math.sqrt(self.leg_length / GRAVITY)

    @property
    def implicit(self) -> bool:
        """Whether forces are taken at the end of the step."""
        return self.integrator == "implicit"

    @property
    def limits(self) -> motor.Limits | None:
        """Of the motors; None if none is limited."""
        found = np.array([(each.lowest, each.highest) for each in self.anatomy.motors], np.float32)
        return motor.Limits(found[:, 0], found[:, 1]) if np.isfinite(found).any() else None

    @property
    def lookahead(self) -> float:
        """How far implicit motors and springs look ahead, s."""
        return self.timestep if self.implicit else 0.0

    @property
    def _nodes(self) -> tuple[int, ...]:
        """Of one ground's heights, along and perhaps across."""
        nodes = self.terrain.num_nodes
        return nodes if isinstance(nodes, tuple) else (nodes,)

    @property
    def _tree(self) -> Tree:
        if self.floating is None:
            return PlanarTree(self.model, self.anatomy)
        return FloatingTree(self.floating, self.anatomy)

    @property
    def _feet(self) -> tuple[str, ...]:
        return tuple(leg.foot for leg in self.anatomy.legs)
