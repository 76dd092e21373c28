"""The ground under one walker, and what it does to a point of a foot."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.envs.contact import ContactForce, Footing, SoftContact
from mjxwalk.envs.course import Course
from mjxwalk.envs.terrain import Ground, Terrain

Place = tuple[Float[Array, ""], Float[Array, ""] | None, Float[Array, ""]]  # x, y in space, and z


class Soil(NamedTuple):
    """The ground under one walker: its shape, its law, and how the law is stepped.

    Random ground pushes straight up; a course, where it is not level, along its own normal.
    """

    shape: Ground
    course: Course
    terrain: Terrain
    law: SoftContact
    timestep: float
    implicit: bool

    def force(
        self,
        place: Place,
        velocity: tuple[Float[Array, "*plane"], Float[Array, ""]],
        stretch: Float[Array, "*plane"],
    ) -> ContactForce:
        """Returns the force on a point, level and upward.

        Args:
          place: of the point, m; y is None in the plane.
          velocity: of the point, level and upward, m/s.
          stretch: of the tangential spring, along the ground, at the end of the last step, m.
        """
        x, y, z = place
        here = self.course.under(self.terrain, x)
        ground = self.shape.height(self.terrain, x, y)
        if here is None:
            return self._law(ground - z, velocity, stretch)
        depth = ground + here.height - z
        if here.gradient is None:
            return self._law(depth, velocity, stretch, here.footing)
        # Axes along the slope and out of it; those along y are the world's.
        cosine = jax.lax.rsqrt(1.0 + here.gradient**2)
        sine = here.gradient * cosine
        level, upward = velocity
        along = cosine * _x(level) + sine * upward
        out = cosine * upward - sine * _x(level)
        turned = self._law(depth * cosine, (_with_x(level, along), out), stretch, here.footing)
        pull, normal = _x(turned.tangential), turned.normal
        level = _with_x(turned.tangential, cosine * pull - sine * normal)
        return turned._replace(tangential=level, normal=sine * pull + cosine * normal)

    def _law(
        self, depth: Any, velocity: Any, stretch: Any, footing: Footing | None = None
    ) -> ContactForce:
        return self.law.force(
            depth,
            velocity,
            stretch,
            timestep=self.timestep,
            implicit=self.implicit,
            footing=footing,
        )


def _x(level: Float[Array, "*plane"]) -> Float[Array, ""]:
    """Returns the part along x of what is a number in the plane."""
    return level[0] if level.ndim else level


def _with_x(level: Float[Array, "*plane"], x: Float[Array, ""]) -> Float[Array, "*plane"]:
    """Returns the same with another part along x."""
    return jnp.stack([x, level[1]]) if level.ndim else x
