"""Random numbers: Threefry as integer operations, with the bits that JAX draws.

J. K. Salmon, M. A. Moraes, R. O. Dror and D. E. Shaw (2011), Parallel random numbers: as easy as
1, 2, 3. JAX says how counters are laid out, and how keys are split: its own functions are traced.
A number of 32 bits costs about a hundred operations.
"""

import functools
from collections.abc import Callable, Sequence
from typing import Any

import jax
import numpy as np

from mjxwalk.engines.lanes.frontend.interpreter import (
    Handler,
    Interpreter,
    Keys,
    Known,
    Params,
    Refusal,
    Value,
)
from mjxwalk.engines.lanes.frontend.key_types import implementation, key_type

ROTATIONS = ((13, 15, 26, 6), (17, 29, 16, 24))
PARITY = 0x1BD11BDA
THREEFRY = "threefry2x32"


def _words(number: int) -> Known:
    return Known(np.asarray(number, np.uint32))


def _threefry(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    """Returns the two words that keys make of two counters: twenty rounds, of five keys."""

    def do(op: str, x: Value, y: Value) -> Value:
        return t.apply(op, "uint32", x, y)

    key = [inputs[0], inputs[1]]
    key.append(do("xor", do("xor", *key), _words(PARITY)))
    x, y = do("add", inputs[2], key[0]), do("add", inputs[3], key[1])
    for turn in range(5):
        for distance in ROTATIONS[turn % 2]:
            x = do("add", x, y)
            left, right = _words(distance), _words(32 - distance)
            y = do("xor", x, do("or", do("shl", y, left), do("shr", y, right)))
        x = do("add", x, key[(turn + 1) % 3])
        y = do("add", do("add", y, key[(turn + 2) % 3]), _words(turn + 1))
    return [x, y]


def _implementation(keys: Value) -> Any:
    """Returns JAX's functions of a key's kind.

    Raises:
      Refusal: it is not Threefry's, whose arithmetic only is known here.
    """
    assert isinstance(keys, Keys)
    found = implementation(keys.type)
    if found.name != THREEFRY:
        raise Refusal(f"draws from keys of the kind {found.name}, and it knows {THREEFRY} only")
    return found


def _each_key(
    t: Interpreter, keys: Value, name: str, fixed: tuple[Any, ...], *others: Value
) -> Value:
    """Returns what a function of JAX's makes of each key's words and of a number beside it."""
    assert isinstance(keys, Keys)
    impl, words = _implementation(keys), keys.words
    made: list[Value] = []
    for place in np.ndindex(keys.array.shape):
        args: list[Value] = [
            t.move(lambda x, place=place: x[place], value) for value in (words, *others)
        ]
        types = tuple((x.array.shape, x.dtype) for x in args)
        made += t.call(_traced(getattr(impl, name), types, fixed, _partitionable()), args)
    shape = keys.array.shape
    return t.move(lambda *x: np.stack(x).reshape((*shape, *x[0].shape)), *made)


def _partitionable() -> bool:
    config: Any = jax.config  # whose settings its type does not name
    return bool(config.jax_threefry_partitionable)


@functools.cache
def _traced(
    function: Callable[..., Any],
    types: Sequence[tuple[tuple[int, ...], str]],
    fixed: tuple[Any, ...],
    partitionable: bool,
) -> Any:
    """Returns the jaxpr of a function of arrays; what decides about it are its arguments here."""
    args = [jax.ShapeDtypeStruct(shape, np.dtype(dtype)) for shape, dtype in types]
    return jax.make_jaxpr(lambda *arrays: function(*arrays, *fixed))(*args)


def _bits(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return [_each_key(t, inputs[0], "random_bits", (p["bit_width"], tuple(p["shape"])))]


def _split(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return [_rewrapped(inputs[0], _each_key(t, inputs[0], "split", (tuple(p["shape"]),)))]


def _fold_in(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    keys, messages = inputs
    messages = t.move(lambda x: np.broadcast_to(x, keys.array.shape), messages)
    return [_rewrapped(keys, _each_key(t, keys, "fold_in", (), messages))]


def _seed(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    impl = p["impl"]
    seeds = inputs[0]
    types = (((), seeds.dtype),)
    traced = _traced(impl.seed, types, (), _partitionable())
    made: list[Value] = []
    for place in np.ndindex(seeds.array.shape):
        made += t.call(traced, [t.move(lambda x, place=place: x[place], seeds)])
    shape = seeds.array.shape
    words = t.move(lambda *x: np.stack(x).reshape((*shape, *x[0].shape)), *made)
    return [_keys(words, key_type(impl.name))]


def _rewrapped(keys: Value, words: Value) -> Keys:
    assert isinstance(keys, Keys)
    return _keys(words, keys.type)


def _keys(words: Value, kind: Any) -> Keys:
    assert not isinstance(words, Keys)
    return Keys(words, kind)


def _wrap(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return [_keys(inputs[0], key_type(p["impl"].name))]


def _unwrap(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    assert isinstance(inputs[0], Keys)
    return [inputs[0].words]


def _clone(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return inputs


HANDLERS: dict[str, Handler] = {
    "threefry2x32": _threefry,
    "random_bits": _bits,
    "random_split": _split,
    "random_fold_in": _fold_in,
    "random_seed": _seed,
    "random_wrap": _wrap,
    "random_unwrap": _unwrap,
    "random_clone": _clone,
}
