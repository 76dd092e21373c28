"""Whole trials in C MuJoCo: what a walker senses, what drives it, and what ends its trial.

Independent of the engine that evolved the walker: senses, counters and the rules of a trial are
written once more, in float64. Shared with it: the source of the controller, which says what the
walker is, though JAX compiles it here for float64; and where a trial starts, which is data.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.envs import Action, Flame, Planar7, Terrain, flame, planar7
from mjxwalk.rollout import Controller, Outcome
from mjxwalk.verify import laws
from mjxwalk.verify.bodies import Step, Walkers

MAX_SPEEDS = (50.0, 1000.0)  # m/s, rad/s; beyond, the physics has diverged


class _Trials(NamedTuple):
    """Walkers' trials so far; replaced every step, but for the arrays, which are filled in.

    Attributes:
      steps: of the physics.
      flight_time: since a foot last touched the ground, s.
      torque_cost: N m s.
      work: J.
      x: of the hip, m.
      fell: whether the trial ended by a fall, or by physics that diverged.
      diverged: whether the physics diverged.
      contact: which feet touched the ground in the last step.
      ankle_x: how far each ankle was ahead of the hip then, m.
    """

    steps: Any
    flight_time: Any
    torque_cost: Any
    work: Any
    x: Any
    fell: Any
    diverged: Any
    contact: Any
    ankle_x: Any


def run(
    env: Planar7 | Flame,
    controller: Controller,
    genotype: Any,
    heights: Float[np.ndarray, " walker *node"],
) -> Outcome:
    """Returns what one genotype does on each terrain, as float64 numpy arrays [walker].

    Args:
      env: body, ground and rules of the trials.
      controller: what the genotype becomes.
      genotype: of the one walker.
      heights: of the terrains, m.
    """
    # JAX keeps what it traced with 32 bits for an engine, and takes it for the 64 bits here.
    jax.clear_caches()
    walkers, trials = _begin(env, heights)
    with jax.enable_x64(True), jax.default_device(jax.devices("cpu")[0]):
        double: Any = jax.tree.map(lambda leaf: np.asarray(leaf, np.float64), genotype)

        def acted(memory: Any, seen: Any) -> Any:
            memory, action = controller.act(double, memory, seen)
            return memory, jnp.stack(action)  # in one piece, as each costs a copy

        act = jax.jit(jax.vmap(acted, out_axes=(0, 1)))
        memory = _repeated(jax.jit(controller.init)(double), len(heights))
        walking = np.ones(len(heights), bool)
        while walking.any():
            # All are shown to the controller, those at rest too: another number compiles anew.
            memory, action = act(memory, _observe(env, walkers, trials))
            before = walkers.qpos.copy(), walkers.qvel.copy()
            step = walkers.step(Action(*np.asarray(action)), walking)  # type: ignore[arg-type]
            walking &= ~_judge(env, walkers, trials, walking, step, before)
    return Outcome(
        fitness=trials.x,
        distance=trials.x,
        duration=trials.steps * env.timestep,
        fell=trials.fell,
        diverged=trials.diverged,
        torque_cost=trials.torque_cost,
        work=trials.work,
        steps=trials.steps,
    )


def _begin(env: Planar7 | Flame, heights: Any) -> tuple[Walkers, _Trials]:
    num = len(heights)
    starts = [
        env.reset(Terrain(np.asarray(heights, np.float32), np.int32(row)))  # type: ignore[arg-type]
        for row in range(num)
    ]

    def stacked(name: str) -> Any:
        return np.array([np.asarray(getattr(start, name), np.float64) for start in starts])

    walkers = Walkers(env, stacked("qpos"), stacked("qvel"), heights)
    walkers.stretch = stacked("stretch").reshape(walkers.stretch.shape)
    trials = _Trials(
        steps=np.zeros(num, int),
        flight_time=np.zeros(num),
        torque_cost=np.zeros(num),
        work=np.zeros(num),
        x=stacked("qpos")[:, 0],
        fell=np.zeros(num, bool),
        diverged=np.zeros(num, bool),
        contact=stacked("touching").reshape(num, 2, -1).any(axis=-1),
        ankle_x=stacked("ankle_x"),
    )
    return walkers, trials


def _observe(env: Planar7 | Flame, walkers: Walkers, trials: _Trials) -> Any:
    """Returns what the walkers sense, leaves [walker, ...]."""
    qpos, qvel = walkers.coordinates()
    time, num = trials.steps * env.timestep, len(qpos)
    felt = {"time": time, "contact": trials.contact, "ankle_x": trials.ankle_x}
    if isinstance(env, Planar7):
        return planar7.Observation(
            pitch=qpos[:, 2],
            pitch_rate=qvel[:, 2],
            angle=qpos[:, 3:].reshape(num, 2, 3),
            rate=qvel[:, 3:].reshape(num, 2, 3),
            **felt,
        )
    return flame.Observation(
        torso=qpos[:, 3:6],
        torso_rate=qvel[:, 3:6],
        adduction=qpos[:, 6],
        adduction_rate=qvel[:, 6],
        angle=qpos[:, 7:].reshape(num, 2, 4),
        rate=qvel[:, 7:].reshape(num, 2, 4),
        **felt,
    )


def _judge(
    env: Planar7 | Flame,
    walkers: Walkers,
    trials: _Trials,
    walking: Bool[np.ndarray, " walker"],
    step: Step,
    before: tuple[Any, Any],
) -> Bool[np.ndarray, " walker"]:
    """Counts a step of those that walk, and returns whose trial is over."""
    dt = env.timestep
    sound: Any = _sound(walkers)
    counted = walking & sound
    trials.steps[counted] += 1
    touching: Any = step.push.touching.reshape(len(walking), 2, -1).any(axis=-1)
    flight = np.where(touching.any(axis=-1), 0.0, trials.flight_time + dt)
    torque, power = step.torque, step.torque * step.rate
    trials.torque_cost[counted] += dt * np.abs(torque[counted]).sum(axis=1)
    trials.work[counted] += dt * np.abs(power[counted]).sum(axis=1)
    new: tuple[tuple[Any, Any], ...] = (
        (trials.flight_time, flight),
        (trials.contact, touching),
        (trials.ankle_x, _ahead(env, step, before[0])),
    )
    for held, value in new:
        held[walking] = value[walking]
    walkers.place(walking & ~sound, *before)
    qpos, _ = walkers.coordinates()
    trials.x[walking] = qpos[walking, 0]
    trials.diverged[walking] = ~sound[walking]
    fell: Any = _fallen(env, qpos, walkers.heights) | ~sound | (flight > env.max_flight_time)
    trials.fell[walking] = fell[walking]
    lag = env.min_speed * dt * trials.steps - trials.x
    spent = trials.torque_cost >= env.torque_budget
    return fell | spent | (trials.steps >= round(env.max_time / dt)) | (lag > env.max_lag)


def _sound(walkers: Walkers) -> Bool[np.ndarray, " walker"]:
    """Returns whose physics has not diverged."""
    _, qvel = walkers.coordinates()
    slides = 1 + walkers.body.tangents
    most = np.where(np.arange(qvel.shape[1]) < slides, *MAX_SPEEDS)
    with np.errstate(invalid="ignore", over="ignore"):
        return ((qvel / most) ** 2).sum(axis=1) < 1.0


def _ahead(env: Planar7 | Flame, step: Step, qpos: Any) -> Any:
    """Returns how far each ankle was ahead of the hip, where the torso headed, m."""
    if isinstance(env, Planar7):
        return step.feet[..., 0] - qpos[:, :1]
    yaw = qpos[:, 3:4]
    arms = step.feet - qpos[:, None, :3]
    return np.cos(yaw) * arms[..., 0] + np.sin(yaw) * arms[..., 1]


def _fallen(env: Planar7 | Flame, qpos: Any, heights: Any) -> Bool[np.ndarray, " walking"]:
    """Returns who has fallen by the body's own rules."""
    y = qpos[:, 1] if isinstance(env, Flame) else np.zeros(len(qpos))
    ground = laws.height(env.terrain, heights, qpos[:, 0], y)
    if isinstance(env, Planar7):
        low, (pitch,) = qpos[:, 1] - ground < env.min_hip_height, qpos[:, 2:3].T
        return low | (np.abs(pitch) > env.max_pitch)
    yaw, pitch, roll = qpos[:, 3:6].T
    return (
        (qpos[:, 2] - ground < env.min_hip_height)
        | (np.abs(yaw) > env.max_yaw)
        | (np.abs(pitch) > env.max_pitch)
        | (np.abs(roll) > env.max_roll)
    )


def _repeated(memory: Any, num: int) -> Any:
    return jax.tree.map(lambda leaf: np.repeat(np.asarray(leaf)[None], num, axis=0), memory)
