"""Functions and arguments that both code generators are tested with."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from mjxwalk.controllers import LinearReactive
from mjxwalk.envs import TRIAL_AXES, Planar7, RandomWalk, Trial, Trials

_MAPPED = np.random.default_rng(3)
X = _MAPPED.normal(size=(37, 5)).astype(np.float32)  # not a multiple of any width
INTS = _MAPPED.integers(-20, 20, size=(37, 5)).astype(np.int32)
U = _MAPPED.integers(0, 1 << 32, size=(37, 5), dtype=np.uint32)
_LOOPED = np.random.default_rng(11)
STARTS = _LOOPED.normal(size=203).astype(np.float32)
GROUND = _LOOPED.normal(size=(3, 50)).astype(np.float32)

FUNCTIONS: dict[str, Any] = {
    "arithmetic": lambda x: x * 2 + x / 3 - (1 - x) * -x,
    "division": lambda x: x / (x[::-1] + 3),
    "extremes": lambda x: (jnp.maximum(x, x[0]), jnp.minimum(x, 0.5), jnp.clip(x, -0.5, 0.7)),
    "rounding": lambda x: (jnp.floor(x), jnp.ceil(x), jnp.round(x), jnp.sign(x), jnp.trunc(x)),
    "remainder": lambda x: (x * 7 % 3.0, jnp.fmod(x * 7, -3.0), lax.rem(x * 9, x)),
    "powers": lambda x: (x**2, x**-3, x**7, jnp.square(x), jnp.abs(x) ** 0.3),
    "comparisons": lambda x: (x < 0, x <= 0, x > 0.5, x >= x[0], x == x[1], x != x[2]),
    "logic": lambda x: (~(x > 0), (x > 0) & (x < 1), (x > 0) | (x < -1), (x > 0) ^ (x > 1)),
    "where": lambda x: jnp.where(x > 0, x, jnp.where(x > -1, 2.0, x * 3)),
    "conversion": lambda x: (
        (x * 50).astype(jnp.int32),
        (x > 0).astype(jnp.float32),
        x.astype(bool),
    ),
    "reductions": lambda x: (x.sum(), x.prod(), x.max(), x.min(), (x > 0).all(), (x > 0).any()),
    "extreme places": lambda x: (x.argmax(), x.argmin(), (-x).argmax()),
    "cumulation": lambda x: (jnp.cumsum(x), jnp.cumprod(x), lax.cummax(x, reverse=True)),
    "moving": lambda x: (x[::-2], x[None, :, None], jnp.roll(x, 2), jnp.tile(x, 2), jnp.pad(x, 2)),
    "padding": lambda x: lax.pad(x, 0.5, [(-1, 3, 2)]),
    "joining": lambda x: (jnp.concatenate([x, x[:2]]), jnp.stack([x, -x], 1), jnp.split(x, [2])),
    "outer": lambda x: jnp.outer(x, x) @ x,
    "empty products": lambda x: (x[:0] @ x[:0], jnp.outer(x, x[:0]) @ jnp.outer(x[:0], x)),
    "einsum": lambda x: jnp.einsum("ij,kj->ik", x.reshape(1, 5), jnp.outer(x, x)),
    "cross": lambda x: jnp.cross(x[:3], x[2:]),
    "norm": lambda x: x / jnp.linalg.norm(x),
    "cholesky": lambda x: jnp.linalg.cholesky(jnp.outer(x, x) + 4 * jnp.eye(5)),
    "solve": lambda x: jax.scipy.linalg.cho_solve(
        jax.scipy.linalg.cho_factor(jnp.outer(x, x) + 4 * jnp.eye(5)), x
    ),
    "triangular": lambda x: lax.linalg.triangular_solve(
        jnp.tril(jnp.outer(x, x)) + 2 * jnp.eye(5), x[None], left_side=False, lower=True
    ),
    "sorting": lambda x: (jnp.sort(x), jnp.argsort(x), lax.sort((jnp.round(x), x), num_keys=1)),
    "median": lambda x: jnp.median(x),
    "finite": lambda x: (jnp.isfinite(1 / (x - x[0])), jnp.isnan(jnp.log(x))),
    "constant": lambda x: (jnp.arange(3), 1.5, x[0] * 0 + 2),
    "switch": lambda x: lax.switch((x[0] * 3).astype(jnp.int32), [jnp.sin, jnp.cos, jnp.abs], x),
    "cond": lambda x: lax.cond(x[0] > 0, lambda y: y * 2, lambda y: y - 1, x),
    "scan": lambda x: lax.scan(lambda c, y: (c + y, c * y), 0.0, x, reverse=True),
    # Of more equations than are unrolled; XLA takes 18 GB for a chain of 1,800 operations.
    "long scan": lambda x: lax.scan(
        lambda c, y: (c * 0.9 + y, c), x[0], jnp.arange(1_500.0) / 1_500
    )[0],
    "fori": lambda x: lax.fori_loop(0, 2_000, lambda i, s: s * 0.99 + x[i % 5], x[0]),
    "custom derivative": lambda x: jax.nn.relu(x) + jax.nn.silu(x),
    "gradient": lambda x: jax.grad(lambda y: jnp.sum(jnp.sin(y) * y**2))(x),
    "checkpoint": lambda x: jax.checkpoint(jnp.sin)(x),
    "weak types": lambda x: x + 1 * 2.5,
}


INTEGERS: dict[str, Any] = {
    "arithmetic": lambda i, j: (i + j, i - j, i * j, -i, abs(i)),
    "division": lambda i, j: (lax.div(i, j), lax.rem(i, j), i // 3, i % 7),
    "bits": lambda i, j: (i & j, i | j, i ^ j, ~i),
    "shifts": lambda i, j: (
        lax.shift_left(i, j),
        lax.shift_right_logical(i, j),
        lax.shift_right_arithmetic(i, j),
    ),
    "comparisons": lambda i, j: (i < j, i <= j, i == j, jnp.maximum(i, j), jnp.minimum(i, j)),
    "conversion": lambda i, j: (i.astype(jnp.float32), i.astype(bool), i.astype(jnp.uint8)),
    "bits as floats": lambda i, j: lax.bitcast_convert_type(i, jnp.float32) == 0,
}


def stroll(start: Any, ground: Any, row: Any, limit: Any) -> Any:
    """A walk over a table that ends at a different step for every walker, and is not chaotic."""

    def walking(state: Any) -> Any:
        step, place, _ = state
        return (step < limit) & (place < 4)

    def step(state: Any) -> Any:
        count, place, seen = state
        node = jnp.floor(place * 10).astype(jnp.int32)
        part = place * 10 - node
        height = ground[row, node] * (1 - part) + ground[row, node + 1] * part
        return count + 1, place + 0.01 + 0.02 * jnp.abs(start) + 0.001 * height, seen + height**2

    return lax.while_loop(walking, step, (0, jnp.abs(start), 0.0))


ENV = Planar7(terrain=RandomWalk(roughness=0.004), max_time=3.0)
CONTROLLER = LinearReactive()
AXES: Any = (0, TRIAL_AXES)
TRIALS = Trials(np.asarray(ENV.terrain.sample(jax.random.key(1), 3)))


def weights(count: int, scale: float, seed: int = 0) -> Any:
    rng = np.random.default_rng(seed)
    return jax.tree.map(
        lambda leaf: (rng.normal(size=(count, *np.shape(leaf))) * scale).astype(np.float32),
        CONTROLLER.template(),
    )


def given(count: int) -> Trial:
    return TRIALS.given((np.arange(count) % 3).astype(np.int32))
