"""Measures strategies against evosax's and pycma's: time of ask and tell, and what they find."""

import dataclasses
import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from scipy import stats

from mjxwalk.bench import searches, timing
from mjxwalk.bench.showing import Section, lines
from mjxwalk.strategies import Strategy

CONVERGED = 1e-8  # COCO's precision: what is lower counts as equal
LEVEL = 0.05  # of all comparisons together, by Bonferroni

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


FULL = Sizes(population_size=4_096, repeats=9, dimensions=(10, 40), generations=1_000, seeds=20)
QUICK = Sizes(population_size=4_096, repeats=5, dimensions=(10,), generations=200, seeds=20)


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
        """Comparisons that ours lost, significantly."""
        level = LEVEL / max(1, len(self.qualities))
        return [quality for quality in self.qualities if quality.p_worse < level]


def compare(sizes: Sizes, say: Say) -> Comparison:
    """Returns the comparison; pycma is left out where it is not installed.

    Raises:
      ImportError: evosax is not installed.
    """
    pairs = searches.pairs()
    times: list[Time] = []
    for name, pair in pairs.items():
        times.append(_time(name, pair, sizes))
        last = times[-1]
        say(f"{name}: ask and tell {1e3 * last.ours:.3g} ms, evosax {1e3 * last.evosax:.3g} ms")
    qualities: list[Quality] = []
    for num_weights in sizes.dimensions:
        for name, pair in pairs.items():
            found = _search(name, pair, num_weights, sizes)
            qualities += found
            least = min(quality.p_worse for quality in found)
            say(f"{name}: {num_weights} weights searched, least p of being worse {least:.2g}")
    device = jax.devices()[0]
    return Comparison(
        device=f"{device.platform} {device.device_kind}",
        sizes=sizes,
        times=times,
        qualities=qualities,
    )


def p_worse(ours: Float[np.ndarray, " seed"], others: Float[np.ndarray, " seed"]) -> float:
    """Returns how likely values so much higher are by chance; below `CONVERGED` all are equal."""
    first, second = (np.nan_to_num(np.maximum(v, CONVERGED), nan=np.inf) for v in (ours, others))
    if np.array_equal(np.sort(first), np.sort(second)):
        return 1.0
    result: Any = stats.mannwhitneyu(first, second, alternative="greater")
    return float(result.pvalue)


def show(comparison: Comparison) -> None:
    """Prints the comparison."""
    for section in sections(comparison):
        for line in lines(section):
            print(line)


def sections(comparison: Comparison) -> list[Section]:
    """Returns the comparison as tables."""
    sizes = comparison.sizes
    times = [
        (
            t.strategy,
            f"{t.num_weights:,}",
            f"{1e3 * t.ours:.3g} ms",
            f"{1e3 * t.evosax:.3g} ms",
            f"{t.evosax / t.ours:.3g}",
        )
        for t in comparison.times
    ]
    rows = [
        (
            q.strategy,
            f"{q.function} {q.num_weights}",
            _three(q.ours),
            q.other,
            _three(q.others),
            f"{q.p_worse:.2g}",
        )
        for q in comparison.qualities
    ]
    lost = [f"{q.strategy} on {q.function} {q.num_weights}" for q in comparison.worse]
    return [
        Section(
            f"ask and tell, population {sizes.population_size:,}, medians of {sizes.repeats} in "
            f"turn, {comparison.device}",
            ("strategy", "weights", "ours", "evosax", "evosax / ours"),
            times,
            [],
        ),
        Section(
            f"lowest value after {sizes.generations:,} generations, quartiles of {sizes.seeds} "
            "seeds",
            ("strategy", "function", "ours", "other", "its", "p worse"),
            rows,
            [
                f"p worse: Mann-Whitney U, one-sided; values below {CONVERGED:g} count as equal",
                f"significantly worse at {LEVEL:g} over all {len(rows)} comparisons: "
                f"{', '.join(lost) or 'none'}",
            ],
        ),
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
    found: list[Quality] = []
    for function_name, function in searches.FUNCTIONS.items():
        ours = searches.lowest(pair.ours(size), function, starts, sizes.generations)
        theirs = pair.theirs(size, num_weights)
        others = {"evosax": searches.lowest(theirs, function, starts, sizes.generations)}
        if name == "cma-es":
            try:
                values = searches.lowest_of_pycma(function, starts, sizes.generations)
                others["pycma"] = values
            except ImportError:
                pass
        found += [
            Quality(
                strategy=name,
                function=function_name,
                num_weights=num_weights,
                other=who,
                ours=_quartiles(ours),
                others=_quartiles(values),
                p_worse=p_worse(ours, values),
            )
            for who, values in others.items()
        ]
    return found


def _quartiles(values: Float[np.ndarray, " seed"]) -> tuple[float, float, float]:
    low, middle, high = np.percentile(np.nan_to_num(values, nan=np.inf), [25, 50, 75])
    return float(low), float(middle), float(high)


def measure_and_show(quick: bool, say: Say) -> dict[str, Any]:
    """Compares, prints, and returns the numbers as JSON.

    Raises:
      ImportError: evosax is not installed.
    """
    started = time.perf_counter()
    comparison = compare(QUICK if quick else FULL, say)
    show(comparison)
    say(f"took {time.perf_counter() - started:.0f} s")
    return dataclasses.asdict(comparison)
