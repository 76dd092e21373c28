"""Massively parallel neuroevolution of bipedal walking, on JAX and MuJoCo MJX."""

__version__ = "0.1.0"
