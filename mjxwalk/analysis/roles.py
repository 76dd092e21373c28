"""The angles of a body by role, stance leg and swing leg, of any body with two feet."""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from mjxwalk.controllers import linear_reactive, spatial_reactive
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import Anatomy, anatomy_of
from mjxwalk.envs.observation import BodyObservation

# By role, degrees; ours: wide, as bodies of files start with bent knees.
_RANGES = {"hip": (-80, 100), "knee": (-40, 140), "ankle": (-80, 80)}
_TORSO = (-45, 45)  # degrees
# Of an angle that moves what is below a joint backward, as a knee that bends does.
_BACKWARD = {"hip": -1.0, "knee": 1.0, "ankle": -1.0}


class Roles(NamedTuple):
    """The angles of a body by role.

    Attributes:
      names: of the angles.
      sense: from an observation, and whether the left leg is the stance leg, to senses with an
        `angle` for each name.
      ranges: lowest and highest of each that counts, degrees; ours: what walkers do that do not
        fall, so that figures can be compared.
      is_paper: whether they are those that the networks of study A see.
    """

    names: tuple[str, ...]
    sense: Callable[[Any, Any], Any]
    ranges: tuple[tuple[int, int], ...]
    is_paper: bool = True


_LEGS = ((-50, 50), (-80, 80), (-20, 100), (-20, 130), (-60, 60), (-60, 60))
PLANAR = Roles(linear_reactive.ANGLES, linear_reactive.sense, ((-45, 45), *_LEGS))
SPATIAL = Roles(
    spatial_reactive.ANGLES,
    spatial_reactive.sense,
    ((-45, 45), (-40, 40), (-60, 60), *_LEGS, (-20, 20), (-40, 40), (-40, 40)),
)


class Senses(NamedTuple):
    """Angles in the order of `Roles.names`, rad."""

    angle: Float[Array, " angle"]


@dataclasses.dataclass(frozen=True)
class BodySense:
    """Reads the angles by role of any body with two feet.

    The torso's leans forward; hips and knees that bend, and ankles that lift the toe, are positive.

    Attributes:
      places: of the angles in the observation, of each role those of left and right.
      signs: of the same, by which an angle is multiplied.
    """

    places: tuple[tuple[int, int], ...]
    signs: tuple[tuple[float, float], ...]

    def __call__(self, observation: BodyObservation, left_stance: Bool[Array, ""]) -> Senses:
        """Returns the torso's angle, then of each role the stance leg's and the swing leg's."""
        up = observation.up
        found = [jnp.arctan2(-up[0], up[-1])]
        for places, signs in zip(self.places, self.signs, strict=True):
            left, right = (
                sign * observation.angle[place] for place, sign in zip(places, signs, strict=True)
            )
            found += [jnp.where(left_stance, left, right), jnp.where(left_stance, right, left)]
        return Senses(jnp.stack(found))


def roles_of(env: object) -> Roles | None:
    """Returns the angles by role that a body has; None of bodies without two feet, or roles."""
    anatomy = anatomy_of(env)
    if anatomy is None or len(anatomy.legs) != 2:
        return None
    if {"up", "angle", "contact"} <= {sense.name for sense in anatomy.senses}:
        return _of_body(env, anatomy)
    if "adduction" in anatomy.names:
        return SPATIAL
    jointed = all(None not in (leg.hip, leg.knee, leg.ankle) for leg in anatomy.legs)
    return PLANAR if anatomy.root.is_planar and jointed else None


def _of_body(env: Any, anatomy: Anatomy) -> Roles:
    left, right = anatomy.legs
    shared = [role for role in _RANGES if None not in (getattr(left, role), getattr(right, role))]
    coordinates = [(getattr(left, role), getattr(right, role)) for role in shared]
    backward = _backward(env.model.mujoco, anatomy)
    first = anatomy.root.num
    sense = BodySense(
        tuple((one - first, other - first) for one, other in coordinates),
        tuple(
            (_BACKWARD[role] * backward[one], _BACKWARD[role] * backward[other])
            for role, (one, other) in zip(shared, coordinates, strict=True)
        ),
    )
    names = [f"{leg} {role}" for role in shared for leg in ("stance", "swing")]
    ranges = [_RANGES[role] for role in shared for _ in range(2)]
    return Roles(("torso", *names), sense, (_TORSO, *ranges), is_paper=False)


def _backward(model: Any, anatomy: Anatomy) -> list[float]:
    """Returns of each coordinate the sign of an angle that moves what is below it backward."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return [float(np.sign(data.xaxis[joint][1])) for joint in anatomy.first_joint]
