"""How a walker walks, as a table over time."""

import dataclasses
from typing import Any

import jax
import numpy as np

from mjxwalk import forces, replay
from mjxwalk.engines.pinning import pinned
from mjxwalk.envs import LeggedEnv
from mjxwalk.export.sto import Table
from mjxwalk.settings import override
from mjxwalk.walker import Walker


@dataclasses.dataclass(frozen=True, kw_only=True)
class Take:
    """What is recorded.

    Attributes:
      seconds: after which recording ends.
      frames_per_second: in the trial's time.
      terrain_seed: of the random ground.
      roughness: step of the random ground, m; None for that which its last generation met.
    """

    seconds: float
    frames_per_second: float
    terrain_seed: int
    roughness: float | None


@pinned()
def record(walker: Walker, take: Take) -> Table:
    """Returns coordinates, their rates, motor torques and ground forces, up to the trial's end.

    Raises:
      ValueError: the frame rate or the duration is wrong.
      RunError: the roughness is refused.
    """
    experiment = walker.experiment.as_tested()
    if take.roughness is not None:
        experiment = override(experiment, "env.terrain.roughness", str(take.roughness))
    env = experiment.env
    trials = experiment.sample_trials(jax.random.key(take.terrain_seed), 1)
    given = trials.given(np.zeros(1, np.int32))
    recording = replay.record(
        env,
        experiment.controller,
        jax.tree.map(lambda leaf: np.asarray(leaf)[None], walker.genotype),
        given,
        duration=min(take.seconds, env.max_time),
        frames_per_second=take.frames_per_second,
    )
    felt = forces.measure(env, experiment.controller, walker.genotype, given, recording, 0)
    states, done = recording.states, recording.done[:, 0]
    frames = int(np.argmax(done)) + 1 if done[-1] else len(done)
    steps = np.asarray(states.trial.num_steps[:frames, 0], np.float64)
    columns = [
        # Not the recording's: its times are float32, whose last digits no one wants to see.
        np.round(steps * env.timestep, 9)[:, None],
        states.qpos[:frames, 0],
        states.qvel[:frames, 0],
        felt.torque[:frames],
        felt.ground[:frames].reshape(frames, -1),
    ]
    rows = np.concatenate([np.asarray(part, np.float64) for part in columns], axis=1)
    return Table(_title(walker), _notes(take, experiment), names(env), rows)


def names(env: LeggedEnv) -> tuple[str, ...]:
    """Returns the names of the columns."""
    anatomy = env.anatomy
    return (
        "time",
        *anatomy.names,
        *(f"{name}_rate" for name in anatomy.names),
        *(f"{motor.name}_torque" for motor in anatomy.motors),
        *(f"{point.name}_force_{axis}" for point in anatomy.points for axis in "xyz"),
    )


def _title(walker: Walker) -> str:
    return f"{walker.name} generation {walker.generation} by mjxwalk"


def _notes(take: Take, experiment: Any) -> tuple[str, ...]:
    return (
        "Units are SI: seconds, metres, radians, newtons and newton metres",
        "x is forward, y is left, z is up; root_x, root_y and root_z are of the hip",
        f"Terrain of seed {take.terrain_seed} and roughness {experiment.env.terrain.roughness:g} m",
    )
