"""Massively parallel neuroevolution of bipedal walking, on JAX and MuJoCo MJX."""

from mjxwalk import checkout as checkout

__version__ = "0.1.0"
