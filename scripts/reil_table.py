"""Tells whether the walks of the hip-powered biped hold, and whether it steps or shuffles."""

import dataclasses
import os
import sys
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro

from mjxwalk import cli, outputs, runs, walkers
from mjxwalk.cli.argument_types import Seed
from mjxwalk.experiments import run_config, study_config
from mjxwalk.runs import config, study

Sources = tyro.conf.Positional[tuple[Annotated[str, tyro.conf.arg(metavar="RUN|zoo:NAME")], ...]]
MILESTONE = 20.0  # m; Reil & Massey (2001), section 5
ENOUGH = 0.9  # of the perturbed starts


@dataclasses.dataclass(frozen=True, kw_only=True)
class ReilTable:
    """Tell when each phase first walked 20 m, and let the last phase's best walk again.

    It walks as it evolved, at half its step and from perturbed starts. A walker holds that reaches
    20 m from nine of ten perturbed starts, and from the usual one at half its time step.

    Attributes:
      sources: folders of studies or runs, or walkers that ship with mjxwalk.
      starts: perturbed ones that each is tried from; 0 to let none walk again.
      seed: of the starts.
      csv: file to write the table to as well.
    """

    sources: Sources = ()
    starts: int = 20
    seed: Seed = 0
    csv: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None

    def run(self) -> int:
        """Shows the table and returns the exit code.

        Raises:
          RunError: an argument is wrong, or a walker has another body.
        """
        if not self.sources:
            raise runs.RunError("no runs were named")
        if self.csv is not None:
            outputs.check(self.csv, "--csv")
        if self.starts < 0:
            raise runs.RunError(f"--starts must not be negative, got {self.starts}")
        phases = [_phases(source) for source in self.sources]
        for name in dict.fromkeys(name for each in phases for name in each):
            print(_milestones(name, [each[name] for each in phases if name in each]))
        if self.starts:
            self._walk_again([list(each.values())[-1] for each in phases])
        return 0

    def _walk_again(self, sources: list[str]) -> None:
        """Shows what the best walker of each source does now."""
        import pandas as pd

        from mjxwalk import engines

        engines.prepare()
        table = pd.DataFrame([self._row(source) for source in sources])
        print(table.to_string(index=False, float_format=lambda value: f"{value:.2f}"))
        held = table[table["holds"]]
        print(f"{len(held)} of {len(table)} hold", end="")
        means = ", ".join(f"{name} {held[name].mean():.2f}" for name in ("drift m", *_GAIT))
        print(f"; on average of these {means}" if len(held) else "")
        if self.csv is not None:
            outputs.write_text(self.csv, table.to_csv(index=False))
            outputs.tell(self.csv)

    def _row(self, source: str) -> dict[str, Any]:
        import jax

        walker = walkers.best(source)
        walkers.check_walks(source, walker.experiment)
        if not hasattr(walker.experiment.env, "max_distance"):
            raise runs.RunError(f"{source} is of another study, whose trials have no distance")
        env = walker.experiment.env
        plain = dataclasses.replace(env, terrain=type(env.terrain)())
        half = dataclasses.replace(plain, timestep=plain.timestep / 2)
        key = jax.random.key(self.seed)
        evolved = _walk(walker, plain, plain.level_trials())
        halved = _walk(walker, half, plain.level_trials())
        pushed = _walk(walker, *plain.perturbed(key, plain.sample_trials(key, self.starts)))
        share = float(np.mean(pushed["distance"] >= MILESTONE))
        far = float(halved["distance"][0])
        return {
            "walker": "/".join(Path(source).parts[-2:]),
            "generation": walker.generation,
            "m": float(evolved["distance"][0]),
            "m, half step": far,
            "starts": share,
            "holds": share >= ENOUGH and far >= MILESTONE,
            "drift m": _mean(np.abs(pushed["drift"][pushed["distance"] >= MILESTONE])),
            **{name: _mean(pushed[name]) for name in _GAIT},
        }


def _mean(values: Any) -> float:
    """Returns the mean of what is no NaN; NaN of nothing."""
    known = values[~np.isnan(values)]
    return float(known.mean()) if known.size else float("nan")


def _phases(source: str) -> dict[str, str]:
    """Returns the folders of a study's phases, or the source itself, by name.

    Raises:
      RunError: there is no such source.
    """
    if walkers.in_zoo(source) or not study.is_study(Path(source)):
        walkers.check(source)
        name = "" if walkers.in_zoo(source) else run_config.read(Path(source)).experiment.name
        return {name.rpartition("/")[2]: source}
    given = study_config.read(Path(source))
    found: dict[str, str] = {}
    for number, (name, _) in enumerate(given.phases):
        folder = given.folder(Path(source), number)
        if (folder / config.FILE).is_file():
            walkers.check(str(folder))
            found[name] = str(folder)
    return found


def _milestones(name: str, sources: list[str]) -> str:
    """Returns in how many runs of a phase a walker came to 20 m, when, and how fast."""
    reached: list[int] = []
    speeds: list[float] = []
    far: list[float] = []
    for source in sources:
        if walkers.in_zoo(source):
            continue
        metrics = runs.load(Path(source)).metrics
        there = np.flatnonzero(np.asarray(metrics["best_fitness"]) >= MILESTONE)
        if there.size:
            reached.append(int(metrics["generation"][there[0]]))
            speeds.append(float(metrics["speed_m_s"][there[0]]))
        else:
            far.append(float(np.max(metrics["best_fitness"])))
    text = f"{name}: {len(reached)} of {len(reached) + len(far)} runs reach {MILESTONE:g} m"
    if reached:
        text += (
            f" in generation {min(reached)} to {max(reached)}, median {np.median(reached):g}, at "
            f"{np.mean(speeds):.2f} m/s on average and {max(speeds):.2f} at best"
        )
    return text + (f"; the others {min(far):.1f} to {max(far):.1f} m" if far else "")


_GAIT = ("speed m/s", "step m", "double stance", "stride s", "knee swing deg")


def _walk(walker: Any, env: Any, trials: Any) -> dict[str, Any]:
    """Returns what a walker does in some trials: how far it comes, and its gait."""
    import jax

    from mjxwalk import replay
    from mjxwalk.analysis.footfalls import find_footfalls, observe
    from mjxwalk.analysis.gait import measure_trials

    num = trials.num
    recording = replay.record(
        env,
        walker.experiment.controller,
        jax.tree.map(lambda leaf: np.repeat(np.asarray(leaf)[None], num, axis=0), walker.genotype),
        trials.given(np.arange(num, dtype=np.int32)),
        duration=env.max_time,
    )
    observations = observe(recording, env)
    measured = measure_trials(recording, env)
    last = recording.states
    knees = [
        _knee_swing(observations.angle[: len(each.time), index, :, 2], each.contact)
        for index, each in enumerate(find_footfalls(recording, observations))
    ]
    return {
        "distance": last.qpos[-1, :, 0] + last.ankle_x[-1].min(axis=1),
        "drift": last.qpos[-1, :, 1],
        "speed m/s": measured["speed_m_s"].to_numpy(),
        "step m": measured["step_length_m"].to_numpy(),
        "double stance": measured["double_stance"].to_numpy(),
        "stride s": measured["stride_time_s"].to_numpy(),
        "knee swing deg": np.array(knees),
    }


def _knee_swing(knee: Any, contact: Any) -> float:
    """Returns how far a knee bends and straightens again while its foot is in the air, degrees.

    The mean over all swings of both legs of the highest angle minus the last one.
    """
    bends: list[float] = []
    for leg in (0, 1):
        edges = np.flatnonzero(np.diff(contact[:, leg].astype(np.int8)))
        for start, end in zip(edges[:-1], edges[1:], strict=True):
            if not contact[end, leg]:
                swing = knee[start + 1 : end + 1, leg]
                bends.append(float(swing.max() - swing[-1]))
    return float(np.degrees(np.mean(bends))) if bends else np.nan


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # a few walkers; leave the GPU to its owner
    sys.exit(cli.run("reil_table.py", ReilTable))
