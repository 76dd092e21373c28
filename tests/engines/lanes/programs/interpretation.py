"""What random programs compute: in JAX as they are, and in JAX with rounding that varies.

A walker near a discontinuity (x < 0 where x is a rounding from 0, a place between two rows) may
come out differently from two good compilers. `Reference` finds those: it multiplies every rounded
result by 1 + e, and e is drawn several times. Where the results differ, so may those of the
compiler that is tested.
"""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from engines.lanes.programs.array_operations import PLACES, PRODUCTS, REDUCTIONS, SHAPES
from engines.lanes.programs.operations import CHOOSING, ELEMENTWISE, FUNCTIONS, Operation
from engines.lanes.programs.program import Block, Program, Step
from jax import lax

OPERATIONS: dict[str, Operation] = {
    **FUNCTIONS, **ELEMENTWISE, **CHOOSING, **SHAPES, **REDUCTIONS, **PRODUCTS, **PLACES
}  # fmt: skip
MOST_TURNS = 4  # of a loop whose number of turns a walker computes
NUM_ERRORS = 61  # prime, so that loops over few numbers do not meet the same error every time


class Plain:
    """A program in JAX. A value is an array."""

    def __call__(self, program: Program, *inputs: Any) -> tuple[Any, ...]:
        """Returns what a program makes of a walker's arguments."""
        return tuple(self.block(program.block, [], [self.value(x) for x in inputs]))

    def value(self, array: Any, *doubtful: Any) -> Any:
        """Returns an array as a value that is as doubtful as other values."""
        return jnp.asarray(array)

    def array(self, value: Any) -> jax.Array:
        """Returns the array of a value."""
        return value

    def apply(self, name: str, params: tuple[Any, ...], args: Sequence[Any]) -> Any:
        """Returns an operation on values."""
        return OPERATIONS[name].run(params, *args)

    def block(self, block: Block, around: Sequence[Any], inputs: Sequence[Any]) -> list[Any]:
        """Returns a block's outputs, of the values around it and its own inputs."""
        values = [*around, *inputs]
        for step in block.steps:
            values += self.step(step, values)
        return [values[number] for number in block.outputs]

    def step(self, step: Step, values: Sequence[Any]) -> list[Any]:
        """Returns the values that a step makes."""
        args = [values[number] for number in step.args]
        special = getattr(self, f"_{step.op}", None)
        if special is not None:
            return special(step, values, args)
        return [self.apply(step.op, step.params, args)]

    def _turns(self, step: Step, values: Sequence[Any], args: Sequence[Any]) -> list[Any]:
        """`fori_loop`: a fixed number of turns, or as many as the walker says."""
        (turns,) = step.params
        number, carried = (None, args) if turns is not None else (args[0], args[1:])
        if number is not None:
            turns = self.array(number) & MOST_TURNS

        def body(i: Any, carried: Any) -> Any:
            i = lax.convert_element_type(i, jnp.int32)
            return tuple(self.block(step.blocks[0], values, [self.value(i), *carried]))

        ended = lax.fori_loop(0, turns, body, tuple(carried))
        return [self.value(self.array(v), v, number) for v in ended]

    def _while(self, step: Step, values: Sequence[Any], args: Sequence[Any]) -> list[Any]:
        test, body = step.blocks

        def going(state: Any) -> Any:
            again = self.block(test, values, state[1])[0]
            return (state[0] < MOST_TURNS) & self.array(again)

        def turn(state: Any) -> Any:
            again = self.block(test, values, state[1])[0]
            made = self.block(body, values, state[1])
            return state[0] + 1, tuple(self.value(self.array(v), v, again) for v in made)

        ended = lax.while_loop(going, turn, (jnp.int32(0), tuple(args)))[1]
        again = self.block(test, values, ended)[0]
        return [self.value(self.array(v), v, again) for v in ended]

    def _scan(self, step: Step, values: Sequence[Any], args: Sequence[Any]) -> list[Any]:
        reverse, num_carried = step.params
        carried, rows = args[:num_carried], args[num_carried:]

        def body(state: Any, xs: Any) -> Any:
            given = [self.value(x, whole) for x, whole in zip(xs, rows, strict=True)]
            made = self.block(step.blocks[0], values, [*state, *given])
            state = tuple(made[:num_carried])
            return state, tuple(made[num_carried:])

        ended, made = lax.scan(body, tuple(carried), tuple(map(self.array, rows)), reverse=reverse)
        return [*ended, *map(self.gathered, made)]

    def gathered(self, values: Any) -> Any:
        """Returns a value for each row, stacked, as one value."""
        return values

    def _branch(self, step: Step, values: Sequence[Any], args: Sequence[Any]) -> list[Any]:
        """`cond` or `switch`, by the type of what decides."""
        which = self.array(args[0])
        branches = [
            lambda block=block: tuple(self.block(block, values, [])) for block in step.blocks
        ]
        made = lax.cond(which, *branches) if which.dtype == bool else lax.switch(which, branches)
        return [self.value(self.array(v), v, args[0]) for v in made]


class Reference(Plain):
    """A program in JAX whose rounding varies. A value is (array, whether it is in doubt).

    Args:
      errors: [NUM_ERRORS], factors of which each operation uses some; zeros for none.
    """

    def __init__(self, errors: Any) -> None:
        self.errors = errors
        self.used = 0

    def value(self, array: Any, *doubtful: Any) -> Any:
        doubts = [value[1] for value in doubtful if value is not None]
        doubt = jnp.any(jnp.stack(doubts)) if doubts else jnp.zeros((), bool)
        return jnp.asarray(array), doubt

    def array(self, value: Any) -> jax.Array:
        return value[0]

    def gathered(self, values: Any) -> Any:
        return values[0], jnp.any(values[1])

    def apply(self, name: str, params: tuple[Any, ...], args: Sequence[Any]) -> Any:
        operation = OPERATIONS[name]
        arrays = [array for array, _ in args]
        given = [self._varied(x, 1.0, 0.0) for x in arrays] if operation.sums else arrays
        result = jnp.asarray(operation.run(params, *given))
        wide = result.dtype == np.float64
        rounding = max(operation.rounding, operation.wide_rounding if wide else 0.0)
        result = self._varied(result, rounding, operation.absolute)
        doubts = [doubt for _, doubt in args]
        if operation.doubt is not None:
            doubts.append(jnp.asarray(operation.doubt(arrays, result)))
        if jnp.issubdtype(result.dtype, jnp.floating):
            tiny = 16 * float(jnp.finfo(result.dtype).tiny)
            doubts.append(jnp.any((result != 0) & (jnp.abs(result) < tiny)))  # perhaps a zero
        return result, jnp.any(jnp.stack(doubts)) if doubts else jnp.zeros((), bool)

    def _varied(self, x: jax.Array, rounding: float, absolute: float) -> jax.Array:
        if not jnp.issubdtype(x.dtype, jnp.floating) or not x.size or not (rounding or absolute):
            return x
        places = (self.used + np.arange(x.size).reshape(x.shape)) % NUM_ERRORS
        self.used += x.size
        unit = 2 * jnp.finfo(x.dtype).eps
        error = self.errors[places].astype(x.dtype) * unit
        x = x * (1 + rounding * error)
        return x + absolute * error[...] if absolute else x
