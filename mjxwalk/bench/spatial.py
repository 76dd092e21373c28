"""The spatial body with a controller of its own, for measuring: it was evolved for nothing."""

import dataclasses

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.envs import Flame, Terrain
from mjxwalk.envs.flame import Action, Observation
from mjxwalk.rollout import Outcome, rollout

NUM_MOTORS = 7
NUM_SENSES = 27
# ours, and so are the gains: firm enough to hold the pose that the walker starts in.
STIFFNESS = np.array([200.0, 100.0, 100.0, 60.0, 100.0, 100.0, 60.0], np.float32)  # N m/rad
DAMPING = 0.05 * STIFFNESS  # N m s/rad
RATE_SCALE = 0.1  # s; ours: brings rates to the size of angles
TARGET_SCALE = 0.1  # rad; ours: weights drawn at random tip walkers over, but tear none apart


@dataclasses.dataclass(frozen=True, kw_only=True)
class HeldLinear:
    """Holds each motor by spring and damper at a target that is a weighted sum of all senses.

    Without memory. The genotype is the weights, one row a motor.
    """

    def init(self, weights: Float[Array, "7 27"]) -> tuple[()]:
        """Returns no memory."""
        del weights
        return ()

    def act(
        self, weights: Float[Array, "7 27"], memory: tuple[()], observation: Observation
    ) -> tuple[tuple[()], Action]:
        """Returns no memory and the seven motors' action."""
        seen = observation
        rates = jnp.concatenate([seen.torso_rate, seen.adduction_rate[None], seen.rate.ravel()])
        angles = jnp.concatenate([seen.torso, seen.adduction[None], seen.angle.ravel()])
        senses = [angles, RATE_SCALE * rates, seen.contact.astype(jnp.float32), jnp.ones(1)]
        target = TARGET_SCALE * (weights @ jnp.concatenate(senses))
        gains = jnp.asarray(STIFFNESS), jnp.asarray(DAMPING)
        return memory, Action(jnp.zeros(NUM_MOTORS), target, *gains)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Held:
    """What the bench asks of a study: a body on slightly rough ground, and its controller."""

    env: Flame = Flame()  # on ground of r = 0.002 m
    controller: HeldLinear = HeldLinear()

    def template(self) -> Float[Array, "7 27"]:
        """Returns weights of zero."""
        return jnp.zeros((NUM_MOTORS, NUM_SENSES))

    def sample_terrains(self, key: PRNGKeyArray, num: int) -> Float[Array, "terrain along across"]:
        """Returns terrains, heights in m."""
        return self.env.terrain.sample(key, num)

    def rollout(self, genotype: Float[Array, "7 27"], terrain: Terrain) -> Outcome:
        """Returns what one walker does on one terrain."""
        return rollout(self.env, self.controller, genotype, terrain)
