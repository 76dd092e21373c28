"""Bodies that the tests of `mjxwalk verify` step beside the engines, and what drives them."""

import dataclasses
import functools
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from mjxwalk import robots, walkers
from mjxwalk.envs import (
    Action,
    Course,
    Flame,
    HipTargets,
    LeggedEnv,
    MjcfEnv,
    Payload,
    Planar7,
    Push,
    Reil,
    Slope,
    Stairs,
    Stretches,
    TrialVariation,
    VelocityMotor,
)
from mjxwalk.verify import laws
from mjxwalk.verify.reference import Reference
from mjxwalk.walker import Walker

TOYS = Path(__file__).parents[1] / "toys"
TOY, ODD = ((TOYS / f"{name}_biped.xml").read_text(encoding="utf-8") for name in ("toy", "odd"))
LENIENT: dict[str, Any] = {"max_flight_time": 9.0, "max_time": 9.0}
UPSET: dict[str, Any] = {"min_height": 0.01, "max_pitch": 9.0, "max_roll": 9.0, "max_yaw": 9.0}
# Everything at work: motors at their limit, a load, a hand that rights the trunk, a slope.
BUSY = Reil(
    terrain=TrialVariation(load=8.0, push=0.2, sideways=0.1, pitch_rate=0.3, slope=0.05),
    hips=VelocityMotor(approach=25.0, max_speed=5.0, max_torque=600.0, softness=1e-4),
    knee_extension=0.0,
    knee_damping=20.0,
    assistance=200.0,
    assistance_damping=30.0,
    assistance_lean=0.1,
    assistance_roll=0.5,
    min_height=0.01,
    max_still_time=9.0,
    **LENIENT,
)
BODIES: dict[str, LeggedEnv] = {
    "planar": Planar7(min_hip_height=0.01, **LENIENT),
    "spatial": Flame(min_hip_height=0.01, max_pitch=1.5, max_roll=3.0, **LENIENT),
    "hip-powered": BUSY,
    "toy": MjcfEnv(body=TOY, acting="torque", **UPSET, **LENIENT),
    "odd": MjcfEnv.of(ODD, **UPSET, **LENIENT),
}
ROBOTS: dict[str, LeggedEnv] = {
    name: MjcfEnv.of(robots.text(name), **UPSET, **LENIENT) for name in ("walker2d", "h1", "g1")
}
# Under the feet from the start on: a slope with steps, soft and slippery ground.
COURSE = Course(
    slope=Slope(gradient=0.2, spread=0.1, begin=0.0),
    stairs=Stairs(rise=-0.01, tread=0.1, begin=0.0),
    soft=Stretches(factor=0.6, width=0.2, every=0.4, spread=0.1, begin=0.0),
    slippery=Stretches(factor=0.3, width=0.2, every=0.4, spread=0.1, begin=0.0),
)
ON_COURSE: dict[str, LeggedEnv] = {
    f"{name} on a course": dataclasses.replace(BODIES[name], course=COURSE)
    for name in ("planar", "spatial")
}
BURDENS: dict[str, Any] = {
    "push": Push(speed=0.4, spread=0.2, duration=0.0333, number=2, begin=0.02, every=0.06),
    "payload": Payload(share=0.2, spread=0.1, forward=-0.1, left=0.04, up=0.15),
}
BURDENED: dict[str, LeggedEnv] = {
    f"{name}, pushed and loaded": dataclasses.replace(BODIES[name], **BURDENS)
    for name in ("planar", "spatial", "toy")
}
SHARE = 0.2  # of a motor's strength; feet land, slip and lift


def actions(env: LeggedEnv, num: int) -> Any:
    """Returns actions that drive all motors at once [step, motor].

    They are numbers from -1 to 1 for motors by position.
    """
    motors = env.anatomy.motors
    time = env.timestep * np.arange(num)[:, None]
    waves = np.sin(15.0 * time + np.arange(len(motors)))
    if motors[0].law == "velocity":
        return HipTargets(jnp.asarray(0.5 * waves, jnp.float32))
    if motors[0].law == "position":
        return jnp.asarray(SHARE * waves, jnp.float32)
    strength = np.array([motor.strength for motor in motors])
    parts = SHARE * strength * waves, 0.1 * waves, SHARE * strength + 0.0 * waves, 0.02 * strength
    return Action(*(jnp.asarray(np.broadcast_to(part, waves.shape), jnp.float32) for part in parts))


@functools.cache
def started(env: LeggedEnv) -> tuple[Any, Any]:
    """Returns two trials, and the states that their walkers start in."""
    trials = env.sample_trials(jax.random.key(1), 2)
    if trials.start is None:
        trials = trials._replace(start=np.zeros((2, len(env.START_DEPARTURES)), np.float32))
    reset = jax.jit(env.reset)
    return trials, [jax.device_get(reset(trials.given(np.int32(row)))) for row in range(2)]


@functools.cache
def by_engine(env: LeggedEnv, num: int) -> Any:
    """Returns the two walkers' last state by the environment, in float64; leaves [walker, ...].

    All that rounds to float32 there are constants of the bodies.
    """
    trials, states = started(env)
    plan = actions(env, num)
    with jax.enable_x64(True):
        plan = jax.tree.map(jnp.asarray, double(plan))

        @jax.jit
        def run(state: Any, given: Any) -> Any:
            def step(number: Any, now: Any) -> Any:
                return env.step(now, jax.tree.map(lambda part: part[number], plan), given)

            return jax.lax.fori_loop(0, num, step, state)

        ends = [
            jax.device_get(run(double(states[row]), double(trials.given(np.int32(row)))))
            for row in range(2)
        ]
    return jax.tree.map(lambda *leaves: np.stack(leaves), *ends)


def double(values: Any) -> Any:
    """Returns numbers of float32 as float64."""
    return jax.tree.map(
        lambda leaf: np.asarray(leaf, np.float64) if np.asarray(leaf).dtype == np.float32 else leaf,
        values,
    )


def placed(env: LeggedEnv, at: LeggedEnv | None = None) -> Reference:
    """Returns the same walkers as they start in C MuJoCo.

    Args:
      env: that they walk by.
      at: whose start they have; None for that of `env`.
    """
    trials, states = started(env if at is None else at)
    qpos, qvel = (np.array([getattr(state, name) for state in states]) for name in ("qpos", "qvel"))
    return Reference(env, qpos, qvel, trials)


def by_reference(env: LeggedEnv, num: int, at: LeggedEnv | None = None) -> Reference:
    """Returns the same walkers after so many steps in C MuJoCo."""
    reference, plan = placed(env, at), actions(env, num)
    for step in range(num):
        parts = plan if isinstance(plan, tuple) else (plan,)
        asked = [np.repeat(np.asarray(part[step], np.float64)[None], 2, axis=0) for part in parts]
        if not isinstance(plan, tuple):
            asked = laws.of_numbers(env.anatomy, asked[0])
        reference.step(asked)
    return reference


def with_field(env: Any, path: str, value: Any) -> Any:
    """Returns settings with one field, such as "contact.friction", replaced."""
    name, _, rest = path.partition(".")
    return dataclasses.replace(
        env, **{name: with_field(getattr(env, name), rest, value) if rest else value}
    )


def field(env: Any, path: str) -> Any:
    """Returns a field of settings."""
    name, _, rest = path.partition(".")
    return field(getattr(env, name), rest) if rest else getattr(env, name)


def shorter(name: str, **rules: Any) -> Walker:
    """Returns a walker of the zoo whose trials end early."""
    walker = walkers.best(f"zoo:{name}")
    tried = walker.experiment.as_tested()
    env = dataclasses.replace(tried.env, **rules)
    return dataclasses.replace(walker, experiment=dataclasses.replace(tried, env=env))
