"""One environment for every legged body: its ground, motors, and the rules of a trial.

A body is a subclass with its settings. It says how a trial starts, what is sensed, and what it has
of its own; all else is here: contacts, joint stops, springs and motors, taken at the end of the
step, the mass matrix, and what ends a trial.
"""

import abc
import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar, Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from mjxwalk.envs import checks, dynamics, edge, ending, motor, trial
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import Anatomy
from mjxwalk.envs.contact import ContactForce, SoftContact
from mjxwalk.envs.ending import Ending
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.motor import Action
from mjxwalk.envs.state import State
from mjxwalk.envs.trees import GRAVITY, FloatingTree, Instant, Loads, PlanarTree, Soil, Tree
from mjxwalk.envs.trial import Trial, Trials

# ours: beyond these speeds a simulation has diverged; a foot that spins free reaches 100 rad/s.
MAX_SLIDE_SPEED, MAX_TURN_SPEED = 50.0, 1000.0  # m/s, rad/s


class Driven(NamedTuple):
    """What a step does to the body.

    Attributes:
      acceleration: that the equations solve to, in the order of the coordinates.
      torque: from the rates after the step to what the motors gave in it, N m.
    """

    acceleration: Float[Array, " coordinate"]
    torque: Callable[[Float[Array, " coordinate"]], Float[Array, " motor"]]


class Sprung(NamedTuple):
    """Joints with passive springs and dampers; joints are counted from the root's end."""

    joints: Any
    springs: motor.Springs


@dataclasses.dataclass(frozen=True, kw_only=True)
class LeggedEnv(abc.ABC):
    """A body, its ground and the rules of a trial.

    Attributes:
      terrain: shape of the ground.
      contact: law of the ground.
      timestep: of the physics, s.
      integrator: "implicit" takes contact, joint stops, springs and the action's stiffness and
        damping at the end of the step; "explicit" takes all forces at its start. Positions then
        follow the new velocities (semi-implicit Euler).
      max_flight_time: s without ground contact; beyond it the walker has fallen.
      min_speed: the trial ends when the walker is farther behind one of this speed than
        `max_lag`, m/s.
      max_lag: see `min_speed`, m.
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
    contact: SoftContact
    timestep: float
    integrator: Literal["implicit", "explicit"] = "implicit"
    max_flight_time: float
    min_speed: float
    max_lag: float
    torque_budget: float
    max_time: float

    def __post_init__(self) -> None:
        checks.positive(self, "timestep", "torque_budget", "max_time")
        checks.not_negative(self, "max_flight_time", "min_speed", "max_lag")
        checks.steps(self)
        if self.integrator not in ("implicit", "explicit"):
            raise ValueError(
                f'integrator must be "implicit" or "explicit", got "{self.integrator}"'
            )

    # What a body says.

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
        motors = self.anatomy.motors
        strength = jnp.asarray(np.array([each.strength for each in motors], np.float32))
        damping = jnp.asarray(np.array([each.damping for each in motors], np.float32))
        nothing = jnp.zeros_like(values)
        return Action(strength * jnp.clip(values, -1.0, 1.0), nothing, nothing, damping)

    # What is the same for all.

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
    def implicit(self) -> bool:
        """Whether forces are taken at the end of the step."""
        return self.integrator == "implicit"

    @property
    def limits(self) -> motor.Limits | None:
        """Of the motors; None if none is limited."""
        found = np.array([(each.lowest, each.highest) for each in self.anatomy.motors], np.float32)
        return motor.Limits(found[:, 0], found[:, 1]) if np.isfinite(found).any() else None

    def sample_trials(self, key: PRNGKeyArray, num: int, roughness: float | None = None) -> Trials:
        """Returns independent trials; on ground of its own roughness if none is given, m."""
        terrain = self.terrain
        if roughness is not None and roughness != terrain.roughness:
            terrain = dataclasses.replace(terrain, roughness=roughness)
        return Trials(terrain.sample(key, num))

    def level_trials(self, num: int = 1) -> Trials:
        """Returns trials on level ground from the usual start."""
        return Trials(np.zeros((num, *self._nodes), np.float32))

    def perturbed(self, key: PRNGKeyArray, trials: Trials) -> tuple["LeggedEnv", Trials]:
        """Returns the environment and trials with starts that depart from the usual one.

        All between the largest departures is equally likely.
        """
        shape = (trials.num, len(self.START_DEPARTURES))
        draws = jax.random.uniform(key, shape, minval=-1.0, maxval=1.0)
        return self, trials._replace(start=draws)

    @edge.takes_arrays
    def reset(self, given: Trial) -> State:
        """Returns the state that a trial starts in.

        Raises:
          ValueError: the ground or the start's draws have another shape than the body's.
        """
        edge.check_terrain(given.ground, self._nodes)
        if given.start is not None:
            like = jax.ShapeDtypeStruct((len(self.START_DEPARTURES),), float)
            edge.check_shapes("start", given.start, like)
        return self.start(given)

    @edge.takes_arrays
    def observe(self, state: State) -> Any:
        """Returns what the walker senses."""
        return self.sense(state)

    @edge.takes_arrays
    def step(self, state: State, action: Any, given: Trial) -> State:
        """Returns the walker one physics step later, and whether its trial is over.

        The action is that of the motors, in the anatomy's order. What they give counts as cost and
        work; joint stops and springs are no motors.
        """
        tree, driven = self._tree, self.anatomy.driven
        now, contact, loads = self._seen(state, given)
        moving = self.drive(state, action, now, loads)
        qacc = tree.accelerations(state, now, moving.acceleration)
        qvel = state.qvel + self.timestep * qacc
        moved = state._replace(
            qpos=state.qpos + self.timestep * qvel,
            qvel=qvel,
            stretch=contact.stretch,
            touching=contact.touching,
            ankle_x=self.ankles(state, now),
            trial=trial.count(
                self,
                state.trial,
                touching=contact.touching,
                torque=moving.torque(qvel),
                rate=qvel[driven],
            ),
        )
        moved = moved._replace(own=self.carry_on(state, moved, now, action, given))
        return trial.judge(
            self,
            state,
            moved,
            max_speed=self._max_speed,
            has_fallen=lambda after: self._has_fallen(after, given),
            is_over=self.is_over,
        )

    def drive(self, state: State, action: Any, now: Instant, loads: Loads) -> Driven:
        """Returns what motors, springs and stops do to the body, by motors that give torques.

        Args:
          state: before the step.
          action: an `Action`.
          now: from `Tree.see`.
          loads: on points of bodies.
        """
        motors = self.anatomy.driven
        torque, inertia = self.passive(state)
        angle, before = state.qpos[motors], state.qvel[motors]
        asked = motor.driven(action, angle, before, self.limits, ahead=self.lookahead)
        joints = motors - self.anatomy.root.num
        torque = torque.at[joints].add(asked.torque)
        inertia = inertia.at[joints].add(asked.added_inertia)
        on_root = jnp.zeros(self.anatomy.root.num)
        force, added = (jnp.concatenate([on_root, each]) for each in (torque, inertia))
        solved = dynamics.solve(*self._tree.equations(now, force, added, loads))

        def gave(qvel: Float[Array, " coordinate"]) -> Float[Array, " motor"]:
            rates = before, qvel[motors] if self.implicit else before
            return motor.given(action, angle, rates, self.limits, ahead=self.lookahead)

        return Driven(solved, gave)

    def motor_torques(self, state: State, action: Any, given: Trial) -> Float[Array, " motor"]:
        """Returns what the motors give in this state, N m; the step may change it."""
        del given
        motors = self.anatomy.driven
        angle, rate = state.qpos[motors], state.qvel[motors]
        return motor.driven(action, angle, rate, self.limits, ahead=0.0).torque

    def ground_forces(self, state: State, given: Trial) -> Float[Array, "point 3"]:
        """Returns the ground's force on each contact point, N, by its law in this state.

        Steps take the law implicitly; what they apply is this, up to what a step changes.
        """
        tree = self._tree
        soil = Soil(self.terrain, given.ground, self.contact, 0.0, implicit=False)
        contact, _ = tree.touch(state, tree.see(state), soil)
        along = contact.tangential
        if along.ndim == 1:
            along = jnp.stack([along, jnp.zeros_like(along)], axis=1)
        return jnp.concatenate([along, contact.normal[:, None]], axis=1)

    def passive(self, state: State) -> tuple[Float[Array, " joint"], Float[Array, " joint"]]:
        """Returns torque of stops and springs, N m, and its implicit part as inertia, kg m^2.

        Joints are counted from the root's end.
        """
        root = self.anatomy.root.num
        angle, rate = state.qpos[root:], state.qvel[root:]
        coordinates = self.anatomy.coordinates[root:]
        lower, upper = (
            np.array([getattr(each, end) for each in coordinates], np.float32)
            for end in ("lower", "upper")
        )
        stop = self.stop_law.torque(
            angle, rate, lower, upper, timestep=self.timestep, implicit=self.implicit
        )
        torque, inertia = stop.torque, stop.added_inertia
        if self.springs is not None:
            joints, springs = self.springs
            push = motor.sprung(springs, angle[joints], rate[joints], ahead=self.lookahead)
            torque = torque.at[joints].add(push.torque)
            inertia = inertia.at[joints].add(push.added_inertia)
        return torque, inertia

    def why_ended(self, state: State, ground: float) -> Ending:
        """Returns why a trial ended; see `mjxwalk.envs.ending.explain`."""
        return ending.explain(self, edge.as_arrays(state), ground)

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

    @property
    def _max_speed(self) -> Float[np.ndarray, " coordinate"]:
        speeds = {"m": MAX_SLIDE_SPEED, "rad": MAX_TURN_SPEED}
        return np.array([speeds[each.unit] for each in self.anatomy.coordinates], np.float32)

    def _seen(self, state: State, given: Trial) -> tuple[Instant, ContactForce, Loads]:
        """Returns the body at this instant, what the ground does to it, and all loads on it."""
        tree = self._tree
        now = tree.see(state)
        soil = Soil(self.terrain, given.ground, self.contact, self.timestep, self.implicit)
        contact, loads = tree.touch(state, now, soil)
        return now, contact, {**loads, **self.carried(state, now, given)}

    def _has_fallen(self, after: State, given: Trial) -> Bool[Array, ""]:
        root = self.anatomy.root
        across = None if root.sideways is None else after.qpos[root.sideways]
        ground = self.terrain.height(given.ground, after.qpos[root.forward], across)
        fallen = self.is_low(after, ground)
        for turn, limit in self.max_tilt.items():
            fallen |= jnp.abs(after.qpos[getattr(root, turn)]) > limit
        return fallen
