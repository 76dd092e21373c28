"""Tests that a run is the same whatever settings of JAX's the process that asks for it has."""

import contextlib
import threading
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import pytest
import toy

from mjxwalk import runs
from mjxwalk.cli import main
from mjxwalk.engines import pinning
from mjxwalk.errors import RunError
from mjxwalk.runs.result import npz

Setting = contextlib.AbstractContextManager[Any]


def settings() -> dict[str, Any]:
    return {name: pinning.settings()[name] for name in pinning.PINNED}


@pytest.fixture
def disturbed() -> Any:
    """Sets JAX up as somebody else might have, for one thread."""
    with (
        jax.enable_x64(True),
        jax.threefry_partitionable(False),
        jax.default_prng_impl("rbg"),
        jax.numpy_dtype_promotion("strict"),
        jax.numpy_rank_promotion("raise"),
        jax.default_matmul_precision("bfloat16"),
        jax.debug_nans(True),
        jax.no_execution(True),
    ):
        yield


def test_pins_are_what_jax_does_by_default() -> None:
    assert settings() == {name: value for name, (value, _) in pinning.PINNED.items()}


def test_pins_hold_inside_and_end_with_the_block(disturbed: None) -> None:
    before = settings()
    with pinning.pinned():
        assert settings() == {name: value for name, (value, _) in pinning.PINNED.items()}
        assert jnp.asarray(1.0).dtype == jnp.float32
    assert settings() == before
    assert before["jax_enable_x64"] is True


def test_pins_do_not_reach_another_thread() -> None:
    seen: list[int] = []
    with jax.enable_x64(True), pinning.pinned():
        jax.config.update("jax_enable_x64", True)
        try:
            reader = threading.Thread(target=lambda: seen.append(jnp.asarray(1.0).dtype.itemsize))
            reader.start()
            reader.join()
        finally:
            jax.config.update("jax_enable_x64", False)
    assert seen == [8]


def test_what_cannot_be_pinned_is_refused_by_name() -> None:
    jax.config.update("jax_random_seed_offset", 5)
    try:
        with pytest.raises(RunError, match="^jax_random_seed_offset is 5, and results depend on"):
            with pinning.pinned():
                pass
    finally:
        jax.config.update("jax_random_seed_offset", 0)


def evolved(path: Path) -> tuple[Any, bytes]:
    assert main(["evolve", "--generations", "3", "--seed", "4", "--out", str(path)]) == 0
    run = runs.load(path)
    return run.metrics["best_fitness"].tolist(), npz(run.champion)


def test_a_run_in_a_disturbed_process_has_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    toy.install(monkeypatch)
    usual = evolved(tmp_path / "usual")
    request.getfixturevalue("disturbed")
    assert evolved(tmp_path / "disturbed") == usual
