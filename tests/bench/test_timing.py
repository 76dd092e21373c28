"""Tests of timing, on a clock that the contenders wind themselves."""

import pytest

from mjxwalk.bench import timing


class Clock:
    """Stands still unless something takes time."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def contender(clock: Clock, seconds: float, log: list[str], name: str) -> timing.Contender:
    """Returns work in units of ten that takes so long each."""

    def run(amount: int) -> int:
        clock.now += amount * seconds
        log.append(name)
        return 10 * amount

    return run


def test_contenders_take_turns() -> None:
    clock, log = Clock(), list[str]()
    field = {name: contender(clock, 1.0, log, name) for name in "ab"}
    timing.in_turn(field, {"a": 1, "b": 2}, 3, clock)
    assert log == ["a", "b"] * 3


def test_a_rate_is_the_median_of_work_over_seconds() -> None:
    clock, log = Clock(), list[str]()
    timings = timing.in_turn({"a": contender(clock, 0.5, log, "a")}, {"a": 4}, 2, clock)["a"]
    assert timings == [(40, 2.0), (40, 2.0)]
    assert timing.rate([*timings, timing.Timing(40, 100.0)]) == 20.0


def test_a_ratio_is_that_of_timings_which_followed_on_each_other() -> None:
    """A machine that slows down to a tenth for a while hits both."""
    ours = [timing.Timing(30, 1.0), timing.Timing(30, 10.0), timing.Timing(33, 1.0)]
    theirs = [timing.Timing(10, 1.0), timing.Timing(10, 10.0), timing.Timing(10, 1.0)]
    assert timing.ratio(ours, theirs) == 3.0


@pytest.mark.parametrize("seconds", [1e-7, 1e-3, 0.3, 7.0])
def test_a_calibrated_amount_takes_the_time_asked_for(seconds: float) -> None:
    clock = Clock()
    amount = timing.calibrate(contender(clock, seconds, [], "a"), 0.4, clock)
    assert amount == max(1, round(0.4 / seconds))


def test_the_call_that_compiles_is_not_counted() -> None:
    clock = Clock()
    calls: list[int] = []

    def compiles_first(amount: int) -> int:
        clock.now += 0.1 * amount + (50.0 if not calls else 0.0)
        calls.append(amount)
        return amount

    assert timing.calibrate(compiles_first, 1.0, clock) == 10


def test_work_too_quick_for_the_clock_still_gets_an_amount() -> None:
    clock = Clock()

    def quick(amount: int) -> int:
        clock.now += 1.0 if amount > 10_000 else 0.0
        return amount

    assert timing.calibrate(quick, 0.4, clock) > 1
