"""Measures strategies against evosax's and pycma's: time of ask and tell, and what they find."""

import dataclasses
import importlib.util
import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from scipy import stats

from mjxwalk.bench import searches, timing
from mjxwalk.strategies import Strategy

CONVERGED = 1e-8  # COCO's precision: what is lower counts as equal
LEVEL = 0.05  # of all comparisons together, by Holm
TIMES = "{:<12}  {:>8}  {:>11}  {:>11}  {:>13}"
QUALITIES = "{:<12}  {:<13}  {:<23}  {:<7}  {:<23}  {:>7}"

Say = Callable[[str], None]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sizes:
    """How much is measured.

    Attributes:
      population_size: of the timings.
      repeats: of each timing.
      dimensions: weights of the functions.
      generations: of each search.
      seeds: searches of each function.
    """

    population_size: int
    repeats: int
    dimensions: tuple[int, ...]
    generations: int
    seeds: int


FULL = Sizes(population_size=4_096, repeats=5, dimensions=(10, 40), generations=1_000, seeds=20)
QUICK = Sizes(population_size=4_096, repeats=3, dimensions=(10,), generations=200, seeds=20)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Time:
    """Median time of a generation's ask and tell, s."""

    strategy: str
    num_weights: int
    ours: float
    evosax: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Quality:
    """Lowest values found, quartiles over the seeds, and whether ours are higher.

    Attributes:
      p_worse: one-sided Mann-Whitney U test that ours are higher.
    """

    strategy: str
    function: str
    num_weights: int
    other: str
    ours: tuple[float, float, float]
    others: tuple[float, float, float]
    p_worse: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Comparison:
    """All that was measured."""

    device: str
    sizes: Sizes
    times: list[Time]
    qualities: list[Quality]

    @property
    def worse(self) -> list[Quality]:
        """Comparisons that ours lost, significantly by Holm's procedure."""
        ordered = sorted(self.qualities, key=lambda quality: quality.p_worse)
        lost: list[Quality] = []
        for place, quality in enumerate(ordered):
            if quality.p_worse >= LEVEL / (len(ordered) - place):
                break
            lost.append(quality)
        return lost


def compare(sizes: Sizes, say: Say) -> Comparison:
    """Returns the comparison, told row by row; pycma is left out where it is not installed.

    Raises:
      ImportError: evosax is not installed.
    """
    pairs = searches.pairs()
    device = jax.devices()[0]
    comparison = Comparison(
        device=f"{device.platform} {device.device_kind}", sizes=sizes, times=[], qualities=[]
    )
    for line in head_of_times(comparison):
        say(line)
    for name, pair in pairs.items():
        comparison.times.append(_time(name, pair, sizes))
        say(row_of_time(comparison.times[-1]))
    for line in head_of_qualities(comparison):
        say(line)
    for num_weights in sizes.dimensions:
        for name, pair in pairs.items():
            for quality in _search(name, pair, num_weights, sizes):
                comparison.qualities.append(quality)
                say(row_of_quality(quality))
    for line in remarks(comparison):
        say(line)
    return comparison


def p_worse(ours: Float[np.ndarray, " seed"], others: Float[np.ndarray, " seed"]) -> float:
    """Returns how likely values so much higher are by chance; below `CONVERGED` all are equal."""
    first, second = (np.nan_to_num(np.maximum(v, CONVERGED), nan=np.inf) for v in (ours, others))
    if np.array_equal(np.sort(first), np.sort(second)):
        return 1.0
    result: Any = stats.mannwhitneyu(first, second, alternative="greater")
    return float(result.pvalue)


def head_of_times(comparison: Comparison) -> list[str]:
    """Returns the lines above the timings."""
    sizes = comparison.sizes
    return [
        f"ask and tell, population {sizes.population_size:,}, medians of {sizes.repeats} in turn, "
        f"{comparison.device}",
        TIMES.format("strategy", "weights", "ours", "evosax", "evosax / ours"),
    ]


def row_of_time(time: Time) -> str:
    """Returns a timing as a line."""
    return TIMES.format(
        time.strategy,
        f"{time.num_weights:,}",
        f"{1e3 * time.ours:.3g} ms",
        f"{1e3 * time.evosax:.3g} ms",
        f"{time.evosax / time.ours:.3g}",
    )


def head_of_qualities(comparison: Comparison) -> list[str]:
    """Returns the lines above the searches."""
    sizes = comparison.sizes
    return [
        "",
        f"lowest value after {sizes.generations:,} generations, quartiles of {sizes.seeds} seeds",
        QUALITIES.format("strategy", "function", "ours", "other", "its", "p worse"),
    ]


def row_of_quality(quality: Quality) -> str:
    """Returns what was found as a line."""
    return QUALITIES.format(
        quality.strategy,
        f"{quality.function} {quality.num_weights}",
        _three(quality.ours),
        quality.other,
        _three(quality.others),
        f"{quality.p_worse:.2g}",
    )


def remarks(comparison: Comparison) -> list[str]:
    """Returns the lines below all."""
    lost = [f"{q.strategy} on {q.function} {q.num_weights}, {q.other}" for q in comparison.worse]
    return [
        f"p worse: Mann-Whitney U, one-sided; values below {CONVERGED:g} count as equal",
        f"significantly worse at {LEVEL:g} over all {len(comparison.qualities)} comparisons, by "
        f"Holm: {'; '.join(lost) or 'none'}",
    ]


def _three(quartiles: tuple[float, float, float]) -> str:
    return " ".join(f"{value:.1e}" for value in quartiles)


def _time(name: str, pair: searches.Pair, sizes: Sizes) -> Time:
    size, num_weights = sizes.population_size, pair.num_weights
    made = {"ours": pair.ours(size), "evosax": pair.theirs(size, num_weights)}
    contenders = {who: _generations(strategy, num_weights) for who, strategy in made.items()}
    for contender in contenders.values():
        contender(1)  # compiles
    timings = timing.in_turn(contenders, dict.fromkeys(contenders, 1), sizes.repeats)
    seconds = {who: 1 / timing.rate(taken) for who, taken in timings.items()}
    return Time(strategy=name, num_weights=num_weights, **seconds)


def _generations(strategy: Strategy[Any, Any], num_weights: int) -> timing.Contender:
    """Returns what asks and tells; fitness is a weight, so that no time goes into it."""

    @jax.jit
    def generation(key: Any, state: Any) -> Any:
        key_ask, key_tell = jax.random.split(key)
        population, state = strategy.ask(key_ask, state)
        return strategy.tell(key_tell, population, population[:, 0], state)[0]

    state = jax.jit(strategy.init)(jax.random.key(0), jnp.zeros(num_weights))

    def go_on(amount: int) -> int:
        nonlocal state
        for index in range(amount):
            state = jax.block_until_ready(generation(jax.random.key(index), state))
        return amount

    return go_on


def _search(name: str, pair: searches.Pair, num_weights: int, sizes: Sizes) -> list[Quality]:
    size = searches.usual_population(num_weights)
    starts = searches.start_points(sizes.seeds, num_weights)
    ours = searches.lowest(pair.ours(size), starts, sizes.generations)
    others = {"evosax": searches.lowest(pair.theirs(size, num_weights), starts, sizes.generations)}
    if name == "cma-es" and importlib.util.find_spec("cma") is not None:
        others["pycma"] = searches.lowest_of_pycma(starts, sizes.generations)
    return [
        Quality(
            strategy=name,
            function=function,
            num_weights=num_weights,
            other=who,
            ours=_quartiles(ours[function]),
            others=_quartiles(found[function]),
            p_worse=p_worse(ours[function], found[function]),
        )
        for function in searches.FUNCTIONS
        for who, found in others.items()
    ]


def _quartiles(values: Float[np.ndarray, " seed"]) -> tuple[float, float, float]:
    low, middle, high = np.percentile(np.nan_to_num(values, nan=np.inf), [25, 50, 75])
    return float(low), float(middle), float(high)


def measure_and_show(quick: bool, say: Say) -> dict[str, Any]:
    """Compares, tells row by row, and returns the numbers as JSON.

    Raises:
      ImportError: evosax is not installed.
    """
    started = time.perf_counter()
    comparison = compare(QUICK if quick else FULL, say)
    say(f"took {time.perf_counter() - started:.0f} s")
    return dataclasses.asdict(comparison)
