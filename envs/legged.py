"""One environment for every legged body: its ground, motors, and the rules of a trial.

A body is a subclass with its settings, which says what `LeggedBody` asks for. All else is here:
contacts, joint stops, springs and motors, taken at the end of the step, the mass matrix, and what
ends a trial.
"""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from mjxwalk.envs import dynamics, edge, ending, motor, trial
from mjxwalk.envs.contact import ContactForce
from mjxwalk.envs.ending import Ending
from mjxwalk.envs.legged_body import LeggedBody
from mjxwalk.envs.soil import Soil
from mjxwalk.envs.state import State
from mjxwalk.envs.trees import Instant, Loads
from mjxwalk.envs.trial import Trial, Trials

# ours: beyond these speeds a simulation has diverged; a foot that spins free reaches 100 rad/s.
MAX_SLIDE_SPEED, MAX_TURN_SPEED = 50.0, 1000.0  # m/s, rad/s
# Folded into the key of the random ground, they lead to draws of their own.
COURSE, PUSH, PAYLOAD = 0x636F7572, 0x70757368, 0x6C6F6164


class Driven(NamedTuple):
    """What a step does to the body.

    Attributes:
      acceleration: that the equations solve to, in the order of the coordinates.
      torque: from the rates after the step to what the motors gave in it, N m.
    """

    acceleration: Float[Array, " coordinate"]
    torque: Callable[[Float[Array, " coordinate"]], Float[Array, " motor"]]


@dataclasses.dataclass(frozen=True, kw_only=True)
class LeggedEnv(LeggedBody):
    """A body, its ground and the rules of a trial; the settings are those of `LeggedBody`."""

    def sample_trials(self, key: PRNGKeyArray, num: int, roughness: float | None = None) -> Trials:
        """Returns independent trials; on ground of its own roughness if none is given, m."""
        terrain = self.terrain
        if roughness is not None and roughness != terrain.roughness:
            terrain = dataclasses.replace(terrain, roughness=roughness)
        return self.equipped(key, Trials(terrain.sample(key, num)))

    def equipped(self, key: PRNGKeyArray, trials: Trials) -> Trials:
        """Returns trials with what the settings add to the random ground.

        Args:
          key: that the grounds were drawn by; other draws come of it here.
          trials: on random ground.
        """
        num, load = trials.num, trials.load
        if self.payload:
            key_load = jax.random.fold_in(key, PAYLOAD)
            load = jax.random.uniform(key_load, (num,), minval=-1.0, maxval=1.0)
        return trials._replace(
            course=self.course.sample(jax.random.fold_in(key, COURSE), num),
            push=self.push.sample(jax.random.fold_in(key, PUSH), num),
            load=load,
            noise=trial.noise_seeds(key, num, self.action_noise),
        )

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
        if given.ground.course is not None:
            edge.check_course(given.ground, (self.course.num_nodes, self.course.num_channels))
        if given.push is not None:
            edge.check_pushes(given.push, self.push.number)
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

        The action is that of the motors, in the anatomy's order, or a number from -1 to 1 for each
        of them. What they give counts as cost and work; joint stops and springs are no motors.
        """
        tree, driven = self._tree, self.anatomy.driven
        self._check_action(action)
        action = self._full(action)
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
        return self._judged(state, moved, given)

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
        motors, action = self.anatomy.driven, self._full(action)
        angle, rate = state.qpos[motors], state.qvel[motors]
        return motor.driven(action, angle, rate, self.limits, ahead=0.0).torque

    def ground_forces(self, state: State, given: Trial) -> Float[Array, "point 3"]:
        """Returns the ground's force on each contact point, N, by its law in this state.

        Steps take the law implicitly; what they apply is this, up to what a step changes.
        """
        tree = self._tree
        soil = self._soil(given, 0.0, implicit=False)
        contact, _ = tree.touch(state, tree.see(state), soil)
        along = contact.tangential
        if along.ndim == 1:
            along = jnp.stack([along, jnp.zeros_like(along)], axis=1)
        return jnp.concatenate([along, contact.normal[:, None]], axis=1)

    def passive(self, state: State) -> tuple[Float[Array, " joint"], Float[Array, " joint"]]:
        """Returns torque of stops, springs and friction, N m, and its implicit part, kg m^2.

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
        if self.friction is not None:
            drag = motor.rubbed(self.friction, rate, ahead=self.lookahead)
            torque, inertia = torque + drag.torque, inertia + drag.added_inertia
        return torque, inertia

    def why_ended(self, state: State, ground: float) -> Ending:
        """Returns why a trial ended; see `mjxwalk.envs.ending.explain`."""
        return ending.explain(self, edge.as_arrays(state), ground)

    @property
    def _max_speed(self) -> Float[np.ndarray, " coordinate"]:
        speeds = {"m": MAX_SLIDE_SPEED, "rad": MAX_TURN_SPEED}
        return np.array([speeds[each.unit] for each in self.anatomy.coordinates], np.float32)

    def _seen(self, state: State, given: Trial) -> tuple[Instant, ContactForce, Loads]:
        """Returns the body at this instant, what the ground does to it, and all loads on it."""
        tree = self._tree
        now = tree.see(state, self._payload(given))
        soil = self._soil(given, self.timestep, implicit=self.implicit)
        contact, loads = tree.touch(state, now, soil)
        for more in (self.carried(state, now, given), self._pushes(state, now, given)):
            for body, each in more.items():
                loads.setdefault(body, []).extend(each)
        return now, contact, loads

    def _payload(self, given: Trial) -> dynamics.PointMass | None:
        """Returns what the torso carries in a trial."""
        if not self.payload or given.load is None:
            return None
        place = self.torso_centre + np.array(self.payload.offset, np.float32)
        return dynamics.PointMass(self._torso, place, self.payload.mass(given.load, self.mass))

    def _pushes(self, state: State, now: Instant, given: Trial) -> Loads:
        """Returns the force of a trial's pushes."""
        if not self.push or given.push is None:
            return {}
        steps = state.trial.num_steps
        change = self.push.acceleration(given.push, steps, self.timestep)
        if self.anatomy.root.is_planar:
            change = change.at[1].set(0.0)
        force = jnp.append(self.mass * change, 0.0)
        if now.axes is not None:
            force = force @ now.axes
        place = dynamics.place_of(now.data, self._torso, self.torso_centre)
        offset = dynamics.point_offset(now.data, place)
        return {self._torso: [dynamics.PointLoad(offset, force, jnp.zeros(()))]}

    @property
    def _torso(self) -> int:
        """Number of the torso, in space in the tree with a free root."""
        model = self.model if self.floating is None else self.floating
        return int(model.mujoco.body(self.anatomy.torso).id)

    def _judged(self, before: State, after: State, given: Trial) -> State:
        """Returns the state after a step with the trial's end in it, if it is one."""
        return trial.judge(
            self,
            before,
            after,
            max_speed=self._max_speed,
            has_fallen=lambda moved: self._has_fallen(moved, given),
            is_over=self.is_over,
        )

    def _full(self, action: Any) -> Any:
        """Returns the action that numbers from -1 to 1 stand for; others as they are."""
        return action if isinstance(action, tuple) else self.scaled_action(action)

    def _soil(self, given: Trial, timestep: float, *, implicit: bool) -> Soil:
        """Returns the ground of a trial, its law taken over such a step."""
        return Soil(self.terrain, self.course, given.ground, self.contact, timestep, implicit)

    def _check_action(self, action: Any) -> None:
        """Raises ValueError unless an action has a number for each motor."""
        names = [each.name for each in self.anatomy.motors]
        for part in jax.tree.leaves(action):
            if jnp.shape(part) != (len(names),):
                raise ValueError(
                    f"an action must have {len(names)} numbers, for {', '.join(names)}, got shape "
                    f"{jnp.shape(part)}"
                )

    def _has_fallen(self, after: State, given: Trial) -> Bool[Array, ""]:
        root = self.anatomy.root
        across = None if root.sideways is None else after.qpos[root.sideways]
        ground = self.ground_height(given, after.qpos[root.forward], across)
        fallen = self.is_low(after, ground)
        for turn, limit in self.max_tilt.items():
            fallen |= jnp.abs(after.qpos[getattr(root, turn)]) > limit
        return fallen
