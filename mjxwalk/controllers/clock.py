"""A policy's clock as two inputs beside its senses: a half sine while a leg is up, and a cosine."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.controllers.controller import Description, NetworkInput
from mjxwalk.controllers.policy import Policy

NAMES = ("clock's max(sin, 0)", "clock's cos")


def num_inputs(policy: Policy) -> int:
    """Returns the number of a policy's senses and of its clock's inputs."""
    return len(policy.layout.inputs) + (len(NAMES) if policy.sees_clock else 0)


def inputs(
    policy: Policy, seen: Float[Array, "side input"], phase: Float[Array, " side"]
) -> Float[Array, "side input_and_clock"]:
    """Returns senses and the clock's inputs, for either side."""
    if not policy.sees_clock:
        return seen
    clock = [jnp.maximum(jnp.sin(phase), 0.0), jnp.cos(phase)]
    return jnp.concatenate([seen, jnp.stack(clock, axis=1)], axis=1)


def lifting(policy: Policy) -> Float[Array, "row input_and_clock"]:
    """Returns weights of senses and clock that lift a policy's legs in turn and feel nothing."""
    weights = np.zeros((len(policy.rows), num_inputs(policy)), np.float32)
    if policy.sees_clock:
        weights[:, len(policy.layout.inputs)] = policy.lift
    return jnp.asarray(weights)


def described(policy: Policy, description: Description) -> Description:
    """Returns a description with the clock's inputs after the others."""
    clock = (
        NetworkInput(name=name, unit="", centre=0.0, scale=1.0, limit=None)
        for name in (NAMES if policy.sees_clock else ())
    )
    return description._replace(inputs=(*description.inputs, *clock))
