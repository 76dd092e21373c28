"""Tests of the dynamics that bodies share."""

import jax
import numpy as np
import pytest

from mjxwalk.envs import dynamics


@pytest.mark.parametrize("size", [1, 2, 9, 15])
def test_solve_agrees_with_numpy_in_float64(size: int) -> None:
    rng = np.random.default_rng(size)
    for scale in (1e-4, 1.0, 1e3):
        root = rng.normal(size=(size, size))
        matrix = scale * (root @ root.T + 0.1 * np.eye(size))
        right = rng.normal(size=size)
        ours = jax.jit(dynamics.solve)(matrix.astype(np.float32), right.astype(np.float32))
        exact = np.linalg.solve(matrix, right)
        # float32 rounding times the condition number, some 1,000 here.
        np.testing.assert_allclose(ours, exact, atol=1e-3 * np.abs(exact).max())


def test_solve_does_not_hang_for_thousands_of_matrices_on_two_devices() -> None:
    from mjxwalk.engines import mjx

    size, num = 15, 2048
    matrices = np.broadcast_to(2.0 * np.eye(size, dtype=np.float32), (num, size, size))
    solutions = mjx.vmap(dynamics.solve)(matrices, np.ones((num, size), np.float32))
    np.testing.assert_array_equal(solutions, 0.5)
