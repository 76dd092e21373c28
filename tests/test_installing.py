"""Tests that what is missing can be installed by the command that is told."""

import sys

import pytest

from mjxwalk import installing


@pytest.mark.parametrize(
    ("extra", "package"),
    [
        ("cuda", "jax[cuda13]>="),
        ("export", "safetensors>="),
        ("ray", "ray>="),
        ("slurm", "submitit>="),
        ("tensorboard", "tensorboard"),
    ],
)
def test_an_extra_is_installed_by_its_packages_into_this_python(extra: str, package: str) -> None:
    assert installing.of_extra(extra).startswith(f"{sys.executable} -m pip install '{package}")
