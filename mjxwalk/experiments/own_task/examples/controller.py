"""A controller of my own: a small network that also feels a clock drives a body that ships.

Evolve it with `mjxwalk evolve FILE`; settings are changed by, say, `--set controller.hidden=16`.
A controller is written for one walker. `act` is traced once by JAX and then run for thousands at a
time, so it must be pure: use jax.numpy, and jnp.where in place of `if`.
"""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk import robots
from mjxwalk.controllers import Controller
from mjxwalk.envs import MjcfEnv
from mjxwalk.envs.mjcf import reader
from mjxwalk.experiments.experiment import Experiment, StrategyChoice


class Weights(NamedTuple):
    """The genotype: any tuple or dict of arrays of floats."""

    inputs: Float[Array, "hidden sense"]
    outputs: Float[Array, "motor hidden"]


class Memory(NamedTuple):
    """What the controller remembers from one step to the next, always of the same shapes."""

    smooth: Float[Array, " motor"]  # the last action, so that motors do not jump


@dataclasses.dataclass(frozen=True, kw_only=True)
class Clocked(Controller):
    """The settings of the controller; a run keeps them, so that they are numbers or texts."""

    hidden: int = 8
    frequency: float = 1.2  # Hz, of the clock
    smoothing: float = 0.05  # s

    num_motors: int = 0  # `on` fills these in
    num_senses: int = 0
    timestep: float = 0.001

    def on(self, env: Any) -> "Clocked":
        """Returns the controller for a body, whose sizes it has to know."""
        motors = len(env.anatomy.motors)
        senses = 2 + sum(len(sense.order) or 1 for sense in env.anatomy.senses if _is_felt(sense))
        return dataclasses.replace(
            self, num_motors=motors, num_senses=senses, timestep=env.timestep
        )

    def template(self) -> Weights:
        """Returns the genotype that the first generation is drawn around.

        Zeros in both layers would be a saddle, so the first has a pattern.
        """
        key = jax.random.key(0)
        first = 0.3 * jax.random.normal(key, (self.hidden, self.num_senses))
        return Weights(first, jnp.zeros((self.num_motors, self.hidden)))

    def init(self, genotype: Weights, /) -> Memory:
        """Returns the memory at the start of a trial."""
        return Memory(jnp.zeros(self.num_motors))

    def act(self, genotype: Weights, memory: Memory, observation: Any, /) -> tuple[Memory, Any]:
        """Returns the new memory, and a number from -1 to 1 for each motor."""
        phase = 2.0 * jnp.pi * self.frequency * observation.time
        clock = jnp.stack([jnp.sin(phase), jnp.cos(phase)])
        senses = jnp.concatenate([clock, observation.up, observation.turning, observation.angle])
        hidden = jnp.tanh(genotype.inputs @ senses)
        asked = jnp.tanh(genotype.outputs @ hidden)
        share = self.timestep / (self.smoothing + self.timestep)
        smooth = memory.smooth + share * (asked - memory.smooth)
        return Memory(smooth), smooth


def _is_felt(sense: Any) -> bool:
    return sense.name in ("up", "turning", "angle")


TASK = Experiment(
    name="clocked",
    # `mjxwalk list` names other bodies; a file of your own is read by its path.
    env=MjcfEnv.of(reader.read(robots.path("walker2d")).text, max_time=10.0),
    controller=Clocked(),
    strategy=StrategyChoice(name="snes", options={"sigma": 0.1}),  # docs/strategies.md has others
    population_size=128,
    generations=100,
    terrains_per_evaluation=1,
)
