"""Operations of random programs: which values they take, what they are in JAX, how they round."""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
from engines.lanes.programs.program import Kind
from hypothesis import strategies as st
from jax import lax

Draw = Callable[[Any], Any]
Choice = tuple[tuple[int, ...], tuple[Any, ...]]  # arguments and parameters

FLOATS = ("float32", "float64")
SIGNED = ("int8", "int16", "int32", "int64")
INTEGERS = (*SIGNED, "uint8", "uint16", "uint32", "uint64")
NUMBERS = (*FLOATS, *INTEGERS)
ANY = (*NUMBERS, "bool")
WORDS = ("float32", "int32", "uint32")


class Impossible(Exception):
    """Raised when a program has no values that an operation could take."""


@dataclasses.dataclass(frozen=True)
class Operation:
    """An operation on arrays.

    Attributes:
      choose: of (draw, kinds of the values so far); returns arguments and parameters.
      run: of (parameters, arrays); returns an array.
      rounding: how many units of the last place two good compilers may differ by; 0 is exact.
      absolute: the same as a share of 1, for results near zero of functions such as sin.
      sums: whether rounding depends on the size of the arguments, as in a sum that cancels.
      doubt: of (arrays, result); whether the result is one that lanes does not promise.
      wide_rounding: as `rounding`, in float64, where XLA itself is further off.
    """

    choose: Callable[[Draw, Sequence[Kind]], Choice]
    run: Callable[..., jax.Array]
    rounding: float = 0.0
    absolute: float = 0.0
    sums: bool = False
    doubt: Callable[..., Any] | None = None
    wide_rounding: float = 0.0


def pick(draw: Draw, kinds: Sequence[Kind], test: Callable[[Kind], bool]) -> int:
    """Returns the number of a value that passes a test, one of the newest.

    Raises:
      Impossible: there is none.
    """
    found = [n for n in reversed(range(len(kinds))) if test(kinds[n])][:8]
    if not found:
        raise Impossible
    return draw(st.sampled_from(found))


def _unary(dtypes: Sequence[str], **parameters: Any) -> Callable[..., Choice]:
    def choose(draw: Draw, kinds: Sequence[Kind]) -> Choice:
        x = pick(draw, kinds, lambda k: k.dtype in dtypes)
        return (x,), tuple(map(draw, parameters.values()))

    return choose


def _same_size(draw: Draw, kinds: Sequence[Kind], x: int) -> int:
    """Returns the number of a value of x's type that stretches to its shape, or to which x does."""
    dtype, shape = kinds[x]
    return pick(draw, kinds, lambda k: k.dtype == dtype and (k.shape in (shape, ()) or not shape))


def _binary(dtypes: Sequence[str]) -> Callable[..., Choice]:
    def choose(draw: Draw, kinds: Sequence[Kind]) -> Choice:
        x = pick(draw, kinds, lambda k: k.dtype in dtypes)
        return (x, _same_size(draw, kinds, x)), ()

    return choose


def _stretched(function: Callable[..., Any]) -> Callable[..., Any]:
    return lambda p, *arrays: function(*jnp.broadcast_arrays(*arrays))


def not_finite(*arrays: Any) -> Any:
    return jnp.any(jnp.stack([jnp.any(~jnp.isfinite(x)) for x in arrays]))


def infinite(arrays: Sequence[Any], result: Any) -> Any:
    """A product may lose NaN and infinity."""
    return not_finite(*arrays) if jnp.issubdtype(result.dtype, jnp.floating) else False


def _zero_last(arrays: Sequence[Any], result: Any) -> Any:
    """The sign of a zero is not kept, so that of its reciprocal is not either."""
    return jnp.any(arrays[-1] == 0) if jnp.issubdtype(result.dtype, jnp.floating) else False


def _any_zero(arrays: Sequence[Any], result: Any) -> Any:
    return jnp.any(jnp.stack([jnp.any(x == 0) for x in arrays]))


def _far(arrays: Sequence[Any], result: Any) -> Any:
    """Angles are reduced exactly up to 1e5."""
    return jnp.any(jnp.abs(arrays[0]) > 1e4)


def _function(
    function: Callable[..., Any],
    rounding: float = 8.0,
    absolute: float = 0.0,
    doubt: Any = None,
    wide: float = 0.0,
) -> Operation:
    return Operation(
        _unary(FLOATS), lambda p, x: function(x), rounding, absolute,
        doubt=doubt, wide_rounding=max(wide, rounding),
    )  # fmt: skip


FUNCTIONS = {
    "sqrt": _function(lax.sqrt, 2), "rsqrt": _function(lax.rsqrt, doubt=_zero_last),
    "recip": _function(lambda x: 1 / x, 4, doubt=_zero_last),
    "sin": _function(lax.sin, 8, 2, _far), "cos": _function(lax.cos, 8, 2, _far),
    "tan": _function(lax.tan, 16, 4, _far), "tanh": _function(lax.tanh), "exp": _function(lax.exp),
    "exp2": _function(lax.exp2, wide=32), "expm1": _function(lax.expm1), "log": _function(lax.log),
    "log1p": _function(lax.log1p, wide=64), "logistic": _function(lax.logistic),
    "atan": _function(lax.atan), "asin": _function(lax.asin), "acos": _function(lax.acos),
    "sinh": _function(lax.sinh, wide=16), "cosh": _function(lax.cosh, wide=16),
    "asinh": _function(lax.asinh), "acosh": _function(lax.acosh),
    "atanh": _function(lax.atanh, wide=64), "cbrt": _function(lax.cbrt),
    "erf": Operation(_unary(("float32",)), lambda p, x: lax.erf(x), 8, 4),
}  # fmt: skip

ELEMENTWISE = {
    "add": Operation(_binary(NUMBERS), _stretched(lax.add), 1),
    "sub": Operation(_binary(NUMBERS), _stretched(lax.sub), 1, doubt=infinite),
    "mul": Operation(_binary(NUMBERS), _stretched(lax.mul), 1, doubt=infinite),
    "div": Operation(_binary(NUMBERS), _stretched(lax.div), 4, doubt=_zero_last),
    "rem": Operation(_binary(NUMBERS), _stretched(lax.rem)),
    "pow": Operation(_binary(FLOATS), _stretched(lax.pow), 16, doubt=_any_zero),
    "atan2": Operation(_binary(FLOATS), _stretched(lax.atan2), 8, doubt=_any_zero),
    "max": Operation(_binary(ANY), _stretched(lax.max)),
    "min": Operation(_binary(ANY), _stretched(lax.min)),
    **{
        name: Operation(_binary(ANY), _stretched(getattr(lax, name)))
        for name in ("lt", "le", "gt", "ge", "eq", "ne")
    },
    "neg": Operation(_unary(NUMBERS), lambda p, x: lax.neg(x)),
    "abs": Operation(_unary((*FLOATS, *SIGNED)), lambda p, x: lax.abs(x)),
    "sign": Operation(_unary((*FLOATS, *SIGNED)), lambda p, x: lax.sign(x)),
    "square": Operation(_unary(NUMBERS), lambda p, x: lax.square(x), 1, doubt=infinite),
    "power": Operation(
        _unary(FLOATS, exponent=st.integers(-4, 5)),
        lambda p, x: lax.integer_pow(x, p[0]), 8, doubt=lambda xs, r: not_finite(*xs, r),
    ),
    "floor": _function(lax.floor, 0), "ceil": _function(lax.ceil, 0),
    "round": Operation(
        _unary(FLOATS, even=st.booleans()), lambda p, x: lax.round(x, lax.RoundingMethod(int(p[0])))
    ),
    "finite": _function(lax.is_finite, 0), "nan": _function(jnp.isnan, 0),
    "and": Operation(_binary((*INTEGERS, "bool")), _stretched(lax.bitwise_and)),
    "or": Operation(_binary((*INTEGERS, "bool")), _stretched(lax.bitwise_or)),
    "xor": Operation(_binary((*INTEGERS, "bool")), _stretched(lax.bitwise_xor)),
    "not": Operation(_unary((*INTEGERS, "bool")), lambda p, x: lax.bitwise_not(x)),
    "shl": Operation(_binary(INTEGERS), _stretched(lax.shift_left)),
    "shr": Operation(_binary(INTEGERS), _stretched(lax.shift_right_logical)),
    "sar": Operation(_binary(INTEGERS), _stretched(lax.shift_right_arithmetic)),
}  # fmt: skip


def _choose_where(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = pick(draw, kinds, lambda k: True)
    y = pick(draw, kinds, lambda k: k == kinds[x])
    test = pick(draw, kinds, lambda k: k.dtype == "bool" and k.shape in (kinds[x].shape, ()))
    return (test, x, y), ()


def _choose_case(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = pick(draw, kinds, lambda k: True)
    y = pick(draw, kinds, lambda k: k == kinds[x])
    z = pick(draw, kinds, lambda k: k == kinds[x])
    which = pick(draw, kinds, lambda k: k.dtype == "int32" and k.shape in (kinds[x].shape, ()))
    return (which, x, y, z), ()


def _choose_three(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = pick(draw, kinds, lambda k: k.dtype in NUMBERS)
    low = pick(draw, kinds, lambda k: k.dtype == kinds[x].dtype and k.shape in (kinds[x].shape, ()))
    return (low, x, pick(draw, kinds, lambda k: k == kinds[low])), ()


def _choose_constant(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    dtype = draw(st.sampled_from(sorted({k.dtype for k in kinds})))
    if dtype in FLOATS:
        numbers = st.sampled_from([0.0, 1.0, -1.0, 0.5, 2.0, -3.0, 0.1, 1e-3, 100.0, 7.5, 1e30,
                                   -1e-30, float("inf")])  # fmt: skip
    elif dtype == "bool":
        numbers = st.booleans()
    else:
        numbers = st.sampled_from(
            [0, 1, 2, 3, 5, 7, 16, 31, 100, *([-1, -2] if dtype in SIGNED else [])]
        )
    count = draw(st.sampled_from([None, 3, 6]))
    if count is None:
        return (), (dtype, draw(numbers))
    return (), (dtype, tuple(draw(numbers) for _ in range(count)))


def _choose_conversion(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = pick(draw, kinds, lambda k: True)
    wide = ["float64", "int64"] if any(k.dtype == "float64" for k in kinds) else []
    narrow = ["float32", "int32", "uint32", "bool", "int8", "uint8", "int16", "uint16"]
    return (x,), (draw(st.sampled_from([*wide, *narrow])),)


CHOOSING = {
    "constant": Operation(_choose_constant, lambda p: jnp.asarray(p[1], p[0])),
    "where": Operation(_choose_where, lambda p, test, x, y: jnp.where(test, x, y)),
    "case": Operation(
        _choose_case, lambda p, which, *xs: lax.select_n(jnp.clip(which, 0, len(xs) - 1), *xs)
    ),
    "clamp": Operation(_choose_three, lambda p, low, x, high: lax.clamp(low, x, high)),
    "convert": Operation(_choose_conversion, lambda p, x: lax.convert_element_type(x, p[0]), 1),
    "bits": Operation(
        _unary(WORDS, dtype=st.sampled_from(WORDS)),
        lambda p, x: lax.bitcast_convert_type(x, p[0]),
        doubt=lambda xs, r: jnp.any((xs[0] == 0) | (xs[0] != xs[0]) | (r != r)),
    ),
}  # fmt: skip
