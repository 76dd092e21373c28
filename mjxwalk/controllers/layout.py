"""What a policy sees and moves, as plain data: senses and motors of a body, and their mirror."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Layout:
    """The senses that a policy reads and the motors that it moves.

    Of a body with sides each has a mirror partner.

    Attributes:
      inputs: names of the senses.
      places: of the senses in the observation, its fields one after the other.
      centre: what is taken off each.
      scale: what each is then divided by.
      input_mirror: place of each sense's partner, of left and right changed; () without sides.
      input_sign: that the partner's value is multiplied by.
      outputs: names of the motors that are moved.
      motors: their places in an action.
      output_mirror: place of each motor's partner among them.
      output_sign: that the partner's value is multiplied by.
      num_motors: of an action.
      lift: of each motor moved, how much of its range lifts its leg, as a leg swings: hip forward,
        knee bent, foot level; 0 of others.
      time: that a fall from the height of the root needs, over the square root of two, s.
      every: steps of the physics from one action to the next.
      timed: whether the observation says the time, as `time`.
    """

    inputs: tuple[str, ...] = ()
    places: tuple[int, ...] = ()
    centre: tuple[float, ...] = ()
    scale: tuple[float, ...] = ()
    input_mirror: tuple[int, ...] = ()
    input_sign: tuple[float, ...] = ()
    outputs: tuple[str, ...] = ()
    motors: tuple[int, ...] = ()
    output_mirror: tuple[int, ...] = ()
    output_sign: tuple[float, ...] = ()
    num_motors: int = 0
    lift: tuple[float, ...] = ()
    time: float = 0.3
    every: int = 1
    timed: bool = True

    @property
    def sides(self) -> int:
        """Two, left and right, or one where everything is a policy's own."""
        return 2 if self.input_mirror else 1

    def read(self, observation: Any) -> Float[Array, " input"]:
        """Returns the scaled senses of an observation."""
        parts = [jnp.ravel(leaf).astype(jnp.float32) for leaf in jax.tree.leaves(observation)]
        seen = jnp.concatenate(parts)[np.array(self.places)]
        centre, scale = (np.array(each, np.float32) for each in (self.centre, self.scale))
        return (seen - centre) * (1.0 / scale)

    def mirrored(self, inputs: Float[Array, " input"]) -> Float[Array, " input"]:
        """Returns the senses of the walker seen in a mirror."""
        return inputs[np.array(self.input_mirror)] * np.array(self.input_sign, np.float32)

    def action(self, outputs: Float[Array, " output"]) -> Float[Array, " motor"]:
        """Returns numbers from -1 to 1 for all motors; those not moved have 0."""
        return jnp.zeros(self.num_motors).at[np.array(self.motors)].set(outputs)


def of_task(env: Any) -> Layout:
    """Returns the layout of an environment whose observation is an array of numbers.

    Raises:
      ValueError: it does not name its observations and actions.
    """
    names = [getattr(env, f"{kind}_names", ()) for kind in ("observation", "action")]
    if not all(names):
        raise ValueError(
            f"{type(env).__name__} must have observation_names and action_names, or be of a body's "
            "file, for a policy to know what it sees and moves"
        )
    seen, moved = names
    return Layout(
        inputs=tuple(seen),
        places=tuple(range(len(seen))),
        centre=(0.0,) * len(seen),
        scale=(1.0,) * len(seen),
        outputs=tuple(moved),
        motors=tuple(range(len(moved))),
        num_motors=len(moved),
        lift=(0.0,) * len(moved),
        timed=False,
    )
