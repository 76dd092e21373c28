"""What Gymnasium's walking tasks have in common, version 5 of each.

Towers et al. (2024), "Gymnasium: a standard interface for reinforcement learning environments",
https://gymnasium.farama.org/environments/mujoco/. Observations, rewards, terminations, noise at the
start, frame skip and integrator are Gymnasium's. Constraints are solved by Newton's method whatever
the file says: all of MuJoCo's solvers look for the same forces, and Gymnasium's Humanoid, which
asks for projected Gauss-Seidel, stops before it has them.
"""

import abc
import dataclasses
from typing import Any, ClassVar, Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from mjxwalk.envs import checks, edge
from mjxwalk.envs._mujoco import mjx
from mjxwalk.envs.gymnasium import files
from mjxwalk.envs.gymnasium import told as task_told
from mjxwalk.envs.gymnasium.state import TaskState
from mjxwalk.envs.gymnasium.told import Told
from mjxwalk.envs.mujoco_law import plain
from mjxwalk.envs.mujoco_law import step as mujoco_step
from mjxwalk.envs.mujoco_law.forward import Forward, MujocoState
from mjxwalk.envs.mujoco_law.plain import PlainModel
from mjxwalk.envs.mujoco_law.settings import MujocoContact
from mjxwalk.envs.trial import Trial, Trials, TrialState, noise_seeds

FASTEST = 1e6  # m/s and rad/s; ours: beyond it a simulation has diverged
GRAVITY = 9.81  # m/s^2


class _Going(NamedTuple):
    """What a control step carries from one step of the physics to the next."""

    body: MujocoState
    told: Told
    torque_cost: Float[Array, ""]
    work: Float[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class GymnasiumTask(abc.ABC):
    """One of Gymnasium's tasks; defaults are Gymnasium's.

    Trials end without a fall after so many steps. Numbers of an action from -1 to 1 stand for the
    file's range of controls; what is beyond costs as much as it says and moves no more than 1.

    Attributes:
      body: MJCF, in itself complete; by default that of the installed Gymnasium.
      frame_skip: steps of the physics in a step of control.
      max_steps: of control, after which a trial ends.
      forward_reward_weight: reward for a speed of 1 m/s along x.
      ctrl_cost_weight: cost of the sum of the squared controls.
      reset_noise_scale: of the noise at the start.
      action_noise: standard deviation of normal noise on the actions of evolving walkers; those of
        Gymnasium have none.
      integrator: what the "file" says, or another, such as "euler", which is four times as fast as
        "rk4".
      iterations: of the solver at most; None for what the file says.
      ls_iterations: on the length of each iteration's step; None for what the file says.
    """

    ID: ClassVar[str]  # as Gymnasium makes it
    FILE: ClassVar[str]  # of Gymnasium
    TOLD: ClassVar[tuple[str, ...]] = ()  # names of the values of `Told` that it needs
    NORMAL_RATES: ClassVar[bool] = False  # whether velocities start from normal noise, or uniform

    body: str = dataclasses.field(default="", repr=False)
    frame_skip: int
    forward_reward_weight: float = 1.0
    ctrl_cost_weight: float
    reset_noise_scale: float
    action_noise: float = 0.0
    max_steps: int = 1000
    integrator: Literal["file", "euler", "implicitfast", "rk4"] = "file"
    iterations: int | None = None
    ls_iterations: int | None = None

    def __post_init__(self) -> None:
        checks.count(self, "frame_skip", "max_steps")
        checks.finite(self, "forward_reward_weight", "ctrl_cost_weight")
        checks.not_negative(self, "reset_noise_scale", "action_noise")
        if self.integrator not in ("file", "euler", "implicitfast", "rk4"):
            raise ValueError(
                'integrator must be "file", "euler", "implicitfast" or "rk4", got '
                f'"{self.integrator}"'
            )
        law = self.law  # refuses numbers of iterations
        if not self.body:
            object.__setattr__(self, "body", files.text(self.FILE))
        if self.body:
            plain.of_text(self.body, law)

    def check_ready(self) -> None:
        """Raises ValueError unless it has a body, which is Gymnasium's."""
        if not self.body:
            raise ValueError(
                f"{self.ID} takes its body from gymnasium, which is not installed; {files.INSTALL}"
            )

    @property
    def law(self) -> MujocoContact:
        """MuJoCo's contacts with the settings of this task."""
        integrator = None if self.integrator == "file" else self.integrator
        return MujocoContact(
            iterations=self.iterations, ls_iterations=self.ls_iterations, integrator=integrator
        )

    @property
    def model(self) -> PlainModel:
        """The body."""
        self.check_ready()
        return plain.of_text(self.body, self.law)

    @property
    def timestep(self) -> float:
        """Of control, s."""
        return self.frame_skip * float(self.model.law.mujoco.opt.timestep)

    @property
    def weight(self) -> float:
        """Of the body, N."""
        return GRAVITY * float(np.sum(self.model.law.mujoco.body_mass))

    @property
    def observation_names(self) -> tuple[str, ...]:
        """What each number of an observation is."""
        return self.names_of(self.model.law.mujoco)

    @property
    def action_names(self) -> tuple[str, ...]:
        """The joint that each number of an action drives."""
        return self.model.names

    def sample_trials(self, key: PRNGKeyArray, num: int, roughness: float | None = None) -> Trials:
        """Returns independent trials, each with the noise of its start; the ground is level."""
        del roughness
        found = self.model.law.mujoco
        key_places, key_rates = jax.random.split(key)
        places = jax.random.uniform(key_places, (num, found.nq), minval=-1.0, maxval=1.0)
        if self.NORMAL_RATES:
            rates = jax.random.normal(key_rates, (num, found.nv))
        else:
            rates = jax.random.uniform(key_rates, (num, found.nv), minval=-1.0, maxval=1.0)
        start = jnp.concatenate([places, rates], axis=1)
        noise = noise_seeds(key, num, self.action_noise)
        return Trials(jnp.zeros((num, 1)), start=start, noise=noise)

    @edge.takes_arrays
    def reset(self, given: Trial) -> TaskState:
        """Returns the state that a trial starts in."""
        model, start = self.model.law.mujoco, given.start
        qpos, qvel = jnp.asarray(self.model.qpos), jnp.zeros(model.nv)
        if start is not None:
            noise = self.reset_noise_scale * start
            # ours: along x nothing depends on where a trial starts, and so it has come no way yet.
            qpos += noise[: model.nq].at[0].set(0.0)
            qvel += noise[model.nq :]
        return self.state_of(qpos, qvel)

    def state_of(self, qpos: Float[Array, " nq"], qvel: Float[Array, " nv"]) -> TaskState:
        """Returns the state of a trial that starts with these positions and velocities."""
        model = self.model.law
        data = model.data.replace(qpos=qpos, qvel=qvel)
        data = mjx.com_vel(model.mjx, mjx.com_pos(model.mjx, mjx.kinematics(model.mjx, data)))
        told = task_told.of_start(data, self.TOLD, self.place)
        nothing = jnp.zeros(())
        return TaskState(qpos, qvel, jnp.zeros_like(qvel), told, nothing, TrialState.begin())

    @edge.takes_arrays
    def step(self, state: TaskState, action: Float[Array, " act"], given: Trial) -> TaskState:
        """Returns the state one step of control later, and whether its trial is over."""
        del given
        self._check_action(action)
        ctrl = plain.controls(self.model, action)
        # Steps of a far walker are told apart by float32 only if they start at x = 0.
        here = _without_x(MujocoState(state.qpos, state.qvel, state.qacc_warmstart))
        end = self._moved(_Going(here, state.told, *jnp.zeros(2)), ctrl)
        moved = end.body.qpos[0]
        told = end.told
        if told.ahead is not None:
            told = told._replace(ahead=told.ahead - moved)
            moved += jnp.asarray(told.ahead) - jnp.asarray(state.told.ahead)
        dt = float(self.model.law.mujoco.opt.timestep)
        trial = state.trial._replace(
            num_steps=state.trial.num_steps + 1,
            torque_cost=state.trial.torque_cost + dt * end.torque_cost,
            work=state.trial.work + dt * end.work,
        )
        after = TaskState(
            end.body.qpos.at[0].add(state.qpos[0]),
            end.body.qvel,
            end.body.qacc_warmstart,
            told,
            state.total,
            trial,
        )
        reward = self.reward(after, moved / self.timestep, ctrl, action)
        return self._judged(state, after._replace(total=state.total + reward))

    def fitness(self, state: TaskState, /) -> Float[Array, ""]:
        """Returns the sum of the rewards, which reinforcement learning calls the return."""
        return state.total

    def place(self, data: Any) -> Float[Array, ""]:
        """Returns where along x the speed is measured, m; the first coordinate."""
        return data.qpos[0]

    @abc.abstractmethod
    def observe(self, state: TaskState, /) -> Float[Array, " obs"]:
        """Returns what Gymnasium's task returns as the observation."""

    @abc.abstractmethod
    def names_of(self, found: Any) -> tuple[str, ...]:
        """Returns what each number of an observation is, of a `mujoco.MjModel`."""

    @abc.abstractmethod
    def reward(
        self,
        after: TaskState,
        speed: Float[Array, ""],
        ctrl: Float[Array, " act"],
        action: Float[Array, " act"],
    ) -> Float[Array, ""]:
        """Returns the reward of a step.

        Args:
          after: the state at its end.
          speed: along x, over the step, m/s.
          ctrl: the controls.
          action: the numbers that stand for them.
        """

    def terminated(self, state: TaskState) -> Bool[Array, ""]:
        """Returns whether a state ends its trial; none does."""
        return jnp.zeros_like(state.trial.fell)

    def _moved(self, going: _Going, ctrl: Float[Array, " act"]) -> _Going:
        """Returns what a step of control comes to from where it begins."""
        model = self.model.law
        asked = plain.action(self.model, ctrl)

        def tell(before: Any, now: Forward, is_first: Any) -> tuple[Told, Float[Array, " act"]]:
            del before, is_first  # MuJoCo's data hold the last
            told = task_told.of_forward(model, now, self.TOLD, self.place)
            return told, now.torque

        def substep(going: _Going, _: None) -> tuple[_Going, None]:
            before = going.told, asked.torque
            moved, (told, torque) = mujoco_step.advance(model, going.body, asked, tell, before)
            rate = moved.qvel[model.driven]
            cost = going.torque_cost + jnp.abs(torque).sum()
            return _Going(moved, told, cost, going.work + jnp.abs(torque * rate).sum()), None

        return jax.lax.scan(substep, going, None, length=self.frame_skip)[0]

    def _judged(self, before: TaskState, after: TaskState) -> TaskState:
        """Returns the state after a step with the trial's end in it, if it is one."""
        # One comparison catches NaN, infinity and runaway speeds alike.
        sound = jnp.sum(after.qvel**2) < FASTEST**2
        after = jax.tree.map(lambda new, old: jnp.where(sound, new, old), after, before)
        fell = self.terminated(after) | ~sound
        done = fell | (after.trial.num_steps >= self.max_steps)
        return after._replace(trial=after.trial._replace(fell=fell, diverged=~sound, done=done))

    def _check_action(self, action: Any) -> None:
        shape = (len(self.model.names),)
        if jnp.shape(action) != shape:
            raise ValueError(f"action must have shape {shape}, got {jnp.shape(action)}")


def _without_x(body: MujocoState) -> MujocoState:
    """Returns a body's state moved along x to where its first coordinate is zero."""
    return body._replace(qpos=body.qpos.at[0].set(0.0))
