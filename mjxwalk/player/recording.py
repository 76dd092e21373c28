"""Lets walkers walk, and puts what the page shows of it together."""

import dataclasses
from typing import Any

import jax
import msgspec
import numpy as np

from mjxwalk import forces, replay
from mjxwalk.engines.pinning import pinned
from mjxwalk.envs import scenery
from mjxwalk.outcomes import cost_of_transport
from mjxwalk.player import bodies
from mjxwalk.player.bodies import Body
from mjxwalk.player.packing import Series, Stored, pack
from mjxwalk.player.shown_walkers import ShownWalkers

FRAMES_PER_SECOND = 50.0  # ours: angles between two frames are a straight line to the eye
MOVE_STEP = 0.0002  # m or rad; ours: a fifth of a millimetre
TORQUE_STEP = 0.05  # N m; ours
FORCE_STEP = 0.5  # N; ours
HEIGHT_STEP = 0.0001  # m; ours


class Figures(msgspec.Struct, frozen=True, kw_only=True):
    """What a walker did in its trial; None where there is no such figure."""

    distance_m: float
    duration_s: float
    speed_m_s: float | None
    cost_of_transport: float | None
    torque_cost: float


class Ground(msgspec.Struct, frozen=True, kw_only=True):
    """Where the nodes of the heights are; along x is the series' last axis.

    Attributes:
      x: of the first node, m.
      y: of the first row of nodes, m; a planar body's ground has one row.
      spacing: of the nodes, m.
      rows: across.
      width: that is drawn of it, m; of several walkers each has its own lane as wide.
    """

    x: float
    y: float
    spacing: float
    rows: int
    width: float


class Told(msgspec.Struct, frozen=True, kw_only=True):
    """A walker of the page.

    Attributes:
      label: in a word or two.
      frames: number of them, up to the end of its trial.
      ending: kind of the end.
      why: it ended, in a few words.
      figures: of its trial.
    """

    label: str
    frames: int
    ending: str
    why: str
    figures: Figures


class Show(msgspec.Struct, frozen=True, kw_only=True):
    """All that the page shows, but the series of numbers.

    Attributes:
      title: of the page.
      what: the walkers are, in a few words.
      facts: on the trial, a name and a text each.
      frame_s: from a frame to the next, s; the last one may come sooner.
      weight_n: of the body, N.
      body: that all walkers have.
      ground: that all walk on.
      walkers: in the order of the series.
      series: where they lie; "walker N NAME" for each walker and name, "heights" for the ground.
    """

    title: str
    what: str
    facts: tuple[tuple[str, str], ...]
    frame_s: float
    weight_n: float
    body: Body
    ground: Ground
    walkers: tuple[Told, ...]
    series: dict[str, Stored]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Take:
    """What is recorded.

    Attributes:
      terrain_seed: of the random ground.
      seconds: after which the recording ends.
    """

    terrain_seed: int = 0
    seconds: float = 60.0


@pinned()
def perform(shown: ShownWalkers, take: Take) -> tuple[Show, str]:
    """Returns what there is to show, and its series as text.

    Raises:
      RunError: the body cannot be shown.
    """
    experiment = shown.experiment
    env = experiment.env
    body = bodies.describe(env)
    trials = experiment.sample_trials(jax.random.key(take.terrain_seed), 1)
    given = trials.given(np.zeros(len(shown), np.int32))
    recording = replay.record(
        env,
        experiment.controller,
        shown.genotypes,
        given,
        duration=min(take.seconds, env.max_time),
        frames_per_second=FRAMES_PER_SECOND,
    )
    around = scenery.around(env, trials.given(0).ground, recording.states.qpos)
    patch = around.patch
    series = {"heights": Series(patch.heights, HEIGHT_STEP)}
    told: list[Told] = []
    root = env.anatomy.root
    for place, label in enumerate(shown.labels):
        genotype = jax.tree.map(lambda leaf, place=place: leaf[place], shown.genotypes)
        felt = forces.measure(env, experiment.controller, genotype, given, recording, place)
        frames = _frames(recording, place)
        state = jax.tree.map(lambda leaf, at=(frames - 1, place): leaf[at], recording.states)
        x, y = (
            0.0 if at is None else float(state.qpos[at]) for at in (root.forward, root.sideways)
        )
        below = around.height(x, y)
        told.append(_tell(experiment, label, frames, state, below))
        moves = recording.states.qpos[:frames, place].T
        pushes = felt.ground[:frames].reshape(frames, -1).T
        series[f"walker {place} moves"] = Series(moves, MOVE_STEP)
        series[f"walker {place} torques"] = Series(felt.torque[:frames].T, TORQUE_STEP)
        series[f"walker {place} pushes"] = Series(pushes, FORCE_STEP)
    stored, text = pack(series)
    show = Show(
        title=shown.source,
        what=shown.what,
        facts=_facts(shown, take),
        frame_s=round(1.0 / (FRAMES_PER_SECOND * env.timestep)) * env.timestep,
        weight_n=float(experiment.weight),
        body=body,
        ground=Ground(
            x=patch.x,
            y=patch.y,
            spacing=patch.spacing,
            rows=len(patch.heights),
            width=around.width,
        ),
        walkers=tuple(told),
        series=stored,
    )
    return show, text


def _frames(recording: replay.Recording, walker: int) -> int:
    """Returns how many frames a walker has: the one in which its trial has ended is its last."""
    done = recording.done[:, walker]
    return int(np.argmax(done)) + 1 if done[-1] else len(done)


def _tell(experiment: Any, label: str, frames: int, state: Any, below: float) -> Told:
    env = experiment.env
    distance, duration = float(state.qpos[0]), float(state.trial.num_steps) * env.timestep
    end = env.why_ended(state, below)
    return Told(
        label=label,
        frames=frames,
        ending=end.kind,
        why=end.text,
        figures=Figures(
            distance_m=distance,
            duration_s=duration,
            speed_m_s=distance / duration if duration > 0 else None,
            cost_of_transport=cost_of_transport(state.trial.work, state.qpos[0], experiment.weight),
            torque_cost=float(state.trial.torque_cost),
        ),
    )


def _facts(shown: ShownWalkers, take: Take) -> tuple[tuple[str, str], ...]:
    experiment = shown.experiment
    env = experiment.env
    added = (("Course", env.course), ("Pushes", env.push), ("Payload", env.payload))
    return (
        ("Experiment", str(experiment.name)),
        ("Body", experiment.env.anatomy.name),
        ("Terrain", f"seed {take.terrain_seed}"),
        ("Roughness", f"{1000 * experiment.env.terrain.roughness:g} mm"),
        *((name, part.words()) for name, part in added if part.words()),
    )
