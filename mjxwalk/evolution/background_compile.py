"""Compiles what a run will need later while it goes on."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from mjxwalk.engines.pinning import pinned
from mjxwalk.rollout import Outcome, TrialRunner


class BackgroundCompile:
    """An evaluator that a thread of its own makes, and compiles by evaluating something.

    What it evaluates is what the evaluator itself would: threads change no result. Use it as a
    context manager, which waits for the thread at the end: an interpreter that exits while XLA
    compiles can crash.
    """

    def __init__(self, make: Callable[[], TrialRunner], population: Any, trials: Any) -> None:
        """Args: make: the evaluator. population, trials: of the shapes to compile for."""
        self._make = make
        self._example = (population, trials)
        self._made: Future[TrialRunner] = Future()
        self._thread = threading.Thread(target=self._work, name="background-compile")

    def __enter__(self) -> "BackgroundCompile":
        return self

    def __exit__(self, *_: object) -> None:
        if self._thread.ident is not None:
            self._thread.join()

    def start(self) -> None:
        """Starts the thread; may be called again."""
        if self._thread.ident is None:
            self._thread.start()

    def check(self) -> None:
        """Returns unless the thread has failed; then raises what it raised."""
        if self._made.done():
            self._made.result()

    def evaluate(self, population: Any, trials: Any, /) -> Outcome:
        """Returns the outcomes as numpy arrays [pop, trial]; waits for the thread.

        Ctrl-C interrupts the waiting. Raises what the thread raised.
        """
        self.start()
        return self._made.result().evaluate(population, trials)

    @pinned()  # in a thread of its own
    def _work(self) -> None:
        try:
            evaluator = self._make()
            evaluator.evaluate(*self._example)
        except BaseException as error:  # raised again in the thread that asks for the evaluator
            self._made.set_exception(error)
        else:
            self._made.set_result(evaluator)
