"""A run in words: before its first generation, after each, and at its end."""

from collections import deque
from pathlib import Path
from typing import Any

from mjxwalk import shell
from mjxwalk.experiments.run_config import Config
from mjxwalk.fitting import Fitting
from mjxwalk.runs import Champion, Metrics, Result
from mjxwalk.runs.metrics import NUM_EVALUATED

UNNAMED = "MuJoCo Model"  # what MuJoCo calls a body whose file does not name it
RECENT = 20  # generations that the time left is judged by


class Clock:
    """The time that a run still needs, from its latest generations."""

    def __init__(self, total: int) -> None:
        self._total = total
        self._recent: deque[float] = deque(maxlen=RECENT)
        self._done = 0

    def tick(self, line: Metrics) -> None:
        """Takes in a generation."""
        self._done = line.generation
        self._recent.append(line.wall_s - line.compile_s)

    @property
    def left_s(self) -> float:
        """Seconds until the last generation ends; 0 before the first."""
        if not self._recent:
            return 0.0
        # The median: the first generation after a start takes longer.
        typical = sorted(self._recent)[len(self._recent) // 2]
        return typical * (self._total - self._done)


def opening(path: Path, config: Config, evaluator: Any) -> list[str]:
    """Returns what is said before the first generation."""
    experiment = config.experiment
    engine = f"engine {evaluator.engine} ({evaluator.why}) on {evaluator.devices}"
    what = f"evolving {experiment.name}{_of_body(experiment)}, seed {config.seed}"
    size = f"at most {experiment.generations} generations of {experiment.population_size}"
    if isinstance(experiment, Fitting):
        return [f"{what}: {experiment.describe()}, {size}, in {path}", engine]
    trials = "trial" if experiment.terrains_per_evaluation == 1 else "trials"
    how_long = f"{experiment.generations} generations"
    goal = experiment.goal
    if goal.trials:
        share = "" if goal.share == 1.0 else f"{100 * goal.share:g} % of "
        how_long = f"until {share}{goal.trials} trials end without a fall, at most {how_long}"
    elif getattr(experiment, "pruning", None) is not None:
        how_long = f"until pruning costs too much, at most {how_long}"
    lines = [
        f"{what}: {how_long} of "
        f"{_walkers(experiment)}, {experiment.terrains_per_evaluation} {trials} "
        f"each, in {path}",
    ]
    if config.origin is not None:
        source, generation = config.origin.source, config.origin.generation
        lines.append(f"starting from the {experiment.start} of {source}, generation {generation}")
    return [*lines, engine]


def _walkers(experiment: Any) -> str:
    """Returns how many walkers a generation has, in words."""
    growth = getattr(experiment, "growth", None)
    if growth is None:
        return f"{experiment.population_size} walkers"
    return (
        f"{growth.part} walkers and as many more, at most {experiment.population_size}, until they "
        f"have done {growth.interactions:,} steps together"
    )


def _of_body(experiment: Any) -> str:
    """Returns the name of a body that a file gave, behind a word."""
    env: Any = getattr(experiment, "env", None)
    named = getattr(env, "body", "") and hasattr(env, "anatomy")
    name = env.anatomy.name if named else ""
    return f" with the body {name}" if name not in ("", UNNAMED) else ""


def figures(line: Metrics, experiment: Any = None) -> list[tuple[str, str]]:
    """Returns a generation's figures by name, ready to show; of walkers if nothing else is said."""
    fitness = (line.best_fitness, line.mean_fitness, line.median_fitness)
    if isinstance(experiment, Fitting):
        errors = "/".join(_number(None if each is None else -each) for each in fitness)
        return [
            ("error best/mean/median", f"{errors} {experiment.unit}"),
            ("steps/s", count(line.steps_per_s)),
        ]
    distances = (line.best_distance_m, line.mean_distance_m, line.median_distance_m)
    evaluated = line.strategy.get(NUM_EVALUATED)
    worths = [("fitness best/mean/median", "/".join(map(_number, fitness)))]
    return [
        *([] if evaluated is None else [("walkers", f"{evaluated:.0f}")]),
        *(worths if fitness != distances else []),
        ("distance best/mean/median", "/".join(_number(d) for d in distances) + " m"),
        ("falls", f"{line.fall_share:.0%}"),
        ("speed", f"{_number(line.speed_m_s)} m/s"),
        ("cost of transport", _number(line.cost_of_transport)),
        ("steps/s", count(line.steps_per_s)),
    ]


def closing(path: Path, config: Config, result: Result) -> list[str]:
    """Returns what was evolved, where it is, and what to type next."""
    champion = result.champion
    evolved = (
        f"evolved {config.experiment.name}, seed {config.seed}: {result.generations} generations, "
        f"{count(result.physics_steps)} physics steps in {duration(result.wall_s)}"
    )
    if isinstance(config.experiment, Fitting):
        found = ", ".join(f"{name} {value:.2f}" for name, value in champion.figures.items())
        return [
            evolved.replace("physics steps", "steps"),
            f"champion of generation {champion.generation}, errors in {config.experiment.unit}: "
            f"{found}",
            f"in {path}",
            f"next: {shell.command('report', path)}",
        ]
    return [
        evolved,
        f"champion of generation {champion.generation}: {worth(champion)}, "
        f"{_number(champion.speed_m_s)} m/s, cost of transport "
        f"{_number(champion.cost_of_transport)}, falls in {champion.fall_rate:.0%} of "
        f"{champion.terrains} new trials",
        f"in {path}",
        f"next: {shell.command('report', path)}",
        *(f"      {shell.command(name, path)}" for name in _next(config.experiment)),
    ]


def _next(experiment: Any) -> list[str]:
    """Returns the command that shows how a champion walks, or whether Gymnasium agrees, if any."""
    from mjxwalk.envs.gymnasium import GymnasiumTask
    from mjxwalk.experiments.experiment import Experiment

    env = getattr(experiment, "env", None)
    if isinstance(env, GymnasiumTask):
        return ["verify"]
    if isinstance(experiment, Experiment) and not hasattr(env, "anatomy"):
        return []  # nothing is known of a body to show
    return ["watch"]


def worth(champion: Champion) -> str:
    """Returns a champion's distance, after its fitness where that is something else."""
    distance = f"{champion.distance_m:.2f} m"
    if champion.fitness in (None, champion.distance_m):
        return distance
    return f"fitness {champion.fitness:.2f}, {distance}"


def count(number: int | float) -> str:
    """Returns a number with k, M or G, three digits or so."""
    for factor, unit in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if number >= factor:
            return f"{number / factor:.3g}{unit}"
    return f"{number:.3g}"


def duration(seconds: float) -> str:
    """Returns a time span in its two largest units."""
    whole = round(seconds)
    if whole < 60:
        return f"{seconds:.1f} s" if seconds < 10 else f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"
