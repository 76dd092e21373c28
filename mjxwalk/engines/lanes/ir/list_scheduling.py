"""The order in which a block computes its values: early enough to keep the CPU's units busy, late
enough to leave few waiting in registers.

LLVM keeps the order that it is given in blocks this long, so it is chosen here: list scheduling.
While few values are live, the ready step with the longest way to the end of the block goes first;
when registers run out, a step that frees one.
"""

import heapq
from collections.abc import Mapping, Sequence

REGISTERS = 32  # values alive beyond which freeing them comes first; AVX-512 has as many registers
ISSUED = 2.0  # vector operations that a CPU starts per cycle
CYCLES = {
    **dict.fromkeys(("add", "sub", "mul", "fma", "max", "min"), 4.0),
    **dict.fromkeys(("and", "or", "xor", "not", "neg", "abs", "shl", "shr", "sar", "bitcast"), 1.0),
    **dict.fromkeys(("select", "lt", "le", "eq", "ne"), 3.0),
    **dict.fromkeys(("floor", "ceil", "rint", "convert"), 6.0),
    **dict.fromkeys(("div", "rem", "sqrt", "rsqrt", "recip"), 20.0),
    **dict.fromkeys(("load", "lookup"), 25.0),
}


def ordered(
    steps: Sequence[int], needs: Mapping[int, Sequence[int]], ops: Mapping[int, str]
) -> list[int]:
    """Returns the steps in the order to compute them.

    Args:
      steps: any order in which every step comes after those that it needs.
      needs: which steps each step needs, each once.
      ops: the operation of each step.
    """
    return _Schedule(steps, needs, ops).run()


class _Schedule:
    """The state of one scheduling: what is ready, alive, and when."""

    def __init__(
        self, steps: Sequence[int], needs: Mapping[int, Sequence[int]], ops: Mapping[int, str]
    ) -> None:
        self.needs = needs
        self.users: dict[int, list[int]] = {step: [] for step in steps}
        for step in steps:
            for need in needs[step]:
                self.users[need].append(step)
        self.cycles = {step: self._cycles(step, ops) for step in steps}
        self.height: dict[int, float] = {}
        for step in reversed(steps):
            way = max((self.height[user] for user in self.users[step]), default=0.0)
            self.height[step] = self.cycles[step] + way
        self.position = {step: float(place) for place, step in enumerate(steps)}
        self.missing = {step: len(needs[step]) for step in steps}
        self.unread = {step: len(self.users[step]) for step in steps}
        self.finished: dict[int, float] = {}
        self.live = 0
        self.clock = 0.0
        self.waiting: list[tuple[float, int]] = []  # ready once the clock gets there
        self.urgent: list[tuple[float, int]] = []  # ready, longest way to the end first
        self.freeing: list[
            tuple[float, int]
        ] = []  # ready or waiting, leave no more alive than before
        self.any: list[tuple[float, int]] = []  # ready or waiting, in the order given
        for step in steps:
            if not needs[step]:
                self._ready(step, 0.0)

    def _cycles(self, step: int, ops: Mapping[int, str]) -> float:
        """A product that only one sum reads fuses with it and takes no time of its own."""
        users = self.users[step]
        if ops[step] == "mul" and len(users) == 1 and ops[users[0]] in ("add", "sub"):
            return 0.0
        return CYCLES.get(ops[step], 4.0)

    def _growth(self, step: int) -> int:
        """Returns how many more values are alive after a step."""
        ends = sum(self.unread[need] == 1 for need in self.needs[step])
        return (1 if self.users[step] else 0) - ends

    def _ready(self, step: int, when: float) -> None:
        heapq.heappush(self.waiting, (when, step))
        heapq.heappush(self.any, (self.position[step], step))
        if self._growth(step) <= 0:
            heapq.heappush(self.freeing, (self.position[step], step))

    def run(self) -> list[int]:
        """Returns all steps, ordered."""
        order: list[int] = []
        while len(order) < len(self.users):
            step = self._next()
            order.append(step)
            self._take(step)
        return order

    def _next(self) -> int:
        """Returns the step to do next; lets time pass if none is ready and registers are free."""
        while True:
            while self.waiting and self.waiting[0][0] <= self.clock:
                _, step = heapq.heappop(self.waiting)
                heapq.heappush(self.urgent, (-self.height[step], step))
            if self.live >= REGISTERS:
                break
            step = self._first(self.urgent)
            if step is not None:
                return step
            if not self.waiting:
                break
            self.clock = self.waiting[0][0]
        for queue in (self.freeing, self.any):
            step = self._first(queue)
            if step is not None:
                return step
        raise ValueError("a step needs one that comes later")

    def _first(self, queue: list[tuple[float, int]]) -> int | None:
        """Returns the first step of a queue that is not done yet."""
        while queue:
            _, step = heapq.heappop(queue)
            if step not in self.finished:
                return step
        return None

    def _take(self, step: int) -> None:
        self.live += self._growth(step)
        start = max([self.clock, *(self.finished[need] for need in self.needs[step])])
        self.finished[step] = start + self.cycles[step]
        self.clock += 1 / ISSUED if self.cycles[step] else 0.0
        for need in self.needs[step]:
            self.unread[need] -= 1
            if self.unread[need] == 1:
                last = next(user for user in self.users[need] if user not in self.finished)
                if self.missing[last] == 0 and self._growth(last) <= 0:
                    heapq.heappush(self.freeing, (self.position[last], last))
        for user in self.users[step]:
            self.missing[user] -= 1
            if self.missing[user] == 0:
                when = max(self.finished[need] for need in self.needs[user])
                self._ready(user, when)
