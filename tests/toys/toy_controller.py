"""A controller of our own for the tests: each joint's torque is a weighted sum of a few senses."""

import dataclasses
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.controllers import Controller
from mjxwalk.envs import Action


@dataclasses.dataclass(frozen=True, kw_only=True)
class ToyController(Controller):
    """Four torques from six senses.

    Attributes:
      strength: torque for an output of one, N m.
    """

    strength: float = 20.0

    def template(self) -> dict[str, Float[Array, "4 6"]]:
        """Returns zeros."""
        return {"weights": jnp.zeros((4, 6))}

    def act(self, genotype: Any, memory: Any, observation: Any, /) -> tuple[Any, Action]:
        """Returns no memory, and the torques."""
        lean = observation.up[:2], observation.turning[1:2]
        senses = jnp.concatenate([*lean, observation.contact, jnp.ones(1)])
        torque = self.strength * jnp.tanh(genotype["weights"] @ senses)
        nothing = jnp.zeros(4)
        return memory, Action(torque, nothing, nothing, nothing)
