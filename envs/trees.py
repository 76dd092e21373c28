"""How a body's tree moves: in the plane by MuJoCo's own kinematics, in space seen from its root.

Both answer the same questions, in the body's coordinates, for one walker at an instant.
"""

import operator
from typing import Any, NamedTuple, Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import dynamics, floating
from mjxwalk.envs.anatomy import Anatomy
from mjxwalk.envs.contact import ContactForce
from mjxwalk.envs.dynamics import PointLoad, PointMass
from mjxwalk.envs.soil import Soil
from mjxwalk.envs.state import State

GRAVITY = 9.81  # m/s^2, as in MuJoCo
Loads = dict[int, list[PointLoad]]  # on each body, by its number


class Instant(NamedTuple):
    """Where the parts of a body are and how they move.

    Attributes:
      data: `mjx.Data` with positions, velocities and bias forces, about a root at the origin.
      axes: of the root, as columns; None where the data are in the world's axes.
    """

    data: Any
    axes: Float[Array, "3 3"] | None


class Touch(NamedTuple):
    """What the ground does: to each contact point, and the same as loads on the feet."""

    contact: ContactForce
    loads: Loads


@runtime_checkable
class Tree(Protocol):
    """A body's tree in the plane or in space."""

    def see(self, state: State, carried: PointMass | None = None) -> Instant:
        """Returns where the parts are and how they move; what is carried is part of the body."""
        ...

    def touch(self, state: State, now: Instant, soil: Soil) -> Touch:
        """Returns what the ground does to the contact points."""
        ...

    def equations(
        self,
        now: Instant,
        force: Float[Array, " coordinate"],
        inertia: Float[Array, " coordinate"],
        loads: Loads,
    ) -> tuple[Float[Array, "coordinate coordinate"], Float[Array, " coordinate"]]:
        """Returns mass matrix and force whose quotient the root's and joints' accelerations are.

        Args:
          now: from `see`.
          force: on the coordinates, N or N m; the root's turns are about its own axes.
          inertia: added to the mass matrix's diagonal, kg or kg m^2.
          loads: on points of bodies.
        """
        ...

    def accelerations(
        self, state: State, now: Instant, solved: Float[Array, " coordinate"]
    ) -> Float[Array, " coordinate"]:
        """Returns the second derivatives of the coordinates, of what the equations solve to."""
        ...

    def bodies(self, now: Instant, names: tuple[str, ...]) -> Float[Array, "body 3"]:
        """Returns where bodies are from the root, m; in the root's axes if it has any."""
        ...


class PlanarTree(NamedTuple):
    """A tree in the plane of x and z."""

    model: dynamics.Model
    anatomy: Anatomy

    def see(self, state: State, carried: PointMass | None = None) -> Instant:
        # The tree is placed at the origin: what it does there does not depend on where it is, and
        # near the origin float32 is finer.
        qpos = state.qpos.at[: self.anatomy.root.num_slides].set(0.0)
        return Instant(dynamics.forward(self.model, qpos, state.qvel, carried), None)

    def touch(self, state: State, now: Instant, soil: Soil) -> Touch:
        contacts: list[ContactForce] = []
        loads: Loads = {}
        model = self.model.mujoco
        for index, each in enumerate(self.anatomy.points):
            site = model.site(each.name).id
            body = int(model.site_bodyid[site])
            point = now.data.site_xpos[site]
            if each.radius:
                point = point.at[2].add(-each.radius)
            offset = dynamics.point_offset(now.data, point)
            velocity = dynamics.point_velocity(now.data, body, offset)
            contact = soil.force(
                (state.qpos[0] + point[0], None, state.qpos[1] + point[2]),
                (velocity[0], velocity[2]),
                state.stretch[index],
            )
            force = jnp.stack([contact.tangential, jnp.zeros(()), contact.normal])
            contacts.append(contact)
            loads.setdefault(body, []).append(PointLoad(offset, force, contact.added_mass))
        return Touch(jax.tree.map(lambda *leaves: jnp.stack(leaves), *contacts), loads)

    def equations(
        self,
        now: Instant,
        force: Float[Array, " coordinate"],
        inertia: Float[Array, " coordinate"],
        loads: Loads,
    ) -> tuple[Float[Array, "coordinate coordinate"], Float[Array, " coordinate"]]:
        return dynamics.equations(self.model, now.data, force, inertia, loads)

    def accelerations(
        self, state: State, now: Instant, solved: Float[Array, " coordinate"]
    ) -> Float[Array, " coordinate"]:
        del state, now
        return solved

    def bodies(self, now: Instant, names: tuple[str, ...]) -> Float[Array, "body 3"]:
        return _bodies(self.model, now, names)


class FloatingTree(NamedTuple):
    """A tree in space, whose root is turned by yaw, pitch and roll; see `mjxwalk.envs.floating`."""

    model: dynamics.Model  # with a free root
    anatomy: Anatomy

    def see(self, state: State, carried: PointMass | None = None) -> Instant:
        axes = floating.rotation(state.qpos[3:6])
        qpos, qvel = self._of_joints(state.qpos), self._of_joints(state.qvel)
        data = floating.forward_from_euler(self.model, qpos, qvel, axes, GRAVITY, carried)
        return Instant(data, axes)

    def touch(self, state: State, now: Instant, soil: Soil) -> Touch:
        data, axes = now.data, _axes(now)

        def push(offset: Array, velocity: Array, stretch: Array) -> tuple[ContactForce, PointLoad]:
            x, y, z = state.qpos[:3] + axes @ offset
            velocity = axes @ velocity
            contact = soil.force((x, y, z), (velocity[:2], velocity[2]), stretch)
            force = jnp.append(contact.tangential, contact.normal) @ axes
            return contact, PointLoad(offset, force, contact.added_mass)

        points = self.anatomy.points
        bodies = np.array([self.model.mujoco.body(point.body).id for point in points])
        places = np.array([point.offset for point in points], np.float32)
        offsets = data.xpos[bodies] + (data.xmat[bodies] @ places[:, :, None])[:, :, 0]
        radii = np.array([point.radius for point in points], np.float32)
        if radii.any():
            offsets -= radii[:, None] * axes[2]
        velocities = jax.vmap(lambda motion, r: motion[3:] + jnp.cross(motion[:3], r))(
            data.cvel[bodies], offsets
        )
        contact, pushed = jax.vmap(push)(offsets, velocities, state.stretch)
        loads: Loads = {}
        for index, body in enumerate(bodies.tolist()):
            load = jax.tree.map(operator.itemgetter(index), pushed)
            loads.setdefault(body, []).append(load)
        return Touch(contact, loads)

    def equations(
        self,
        now: Instant,
        force: Float[Array, " coordinate"],
        inertia: Float[Array, " coordinate"],
        loads: Loads,
    ) -> tuple[Float[Array, "coordinate coordinate"], Float[Array, " coordinate"]]:
        joints, coupling = self._on_joints, self.anatomy.coupling
        mass, right = dynamics.equations(
            self.model, now.data, joints(force), joints(inertia), loads
        )
        return dynamics.coupled(mass, right, coupling)

    def accelerations(
        self, state: State, now: Instant, solved: Float[Array, " coordinate"]
    ) -> Float[Array, " coordinate"]:
        turning = floating.euler_acceleration(state.qpos[3:6], state.qvel[3:6], solved[3:6])
        return jnp.concatenate([_axes(now) @ solved[:3], turning, solved[6:]])

    def bodies(self, now: Instant, names: tuple[str, ...]) -> Float[Array, "body 3"]:
        return _bodies(self.model, now, names)

    def _of_joints(self, values: Float[Array, " coordinate"]) -> Float[Array, " joint"]:
        """Returns the values of the joints that coordinates move."""
        if self.anatomy.coupling is None:
            return values
        return values[np.array(self.anatomy.joint_coordinate)]

    def _on_joints(self, values: Float[Array, " coordinate"]) -> Float[Array, " joint"]:
        """Returns each coordinate's value for the first of its joints, nothing for the others."""
        parts: list[Array] = []
        begun = 0
        first = self.anatomy.first_joint
        for joint in range(len(self.anatomy.joint_coordinate)):
            if joint not in first:
                done = int(np.searchsorted(first, joint))
                parts += [values[begun:done], jnp.zeros(1)]
                begun = done
        return jnp.concatenate([*parts, values[begun:]]) if parts else values


def _axes(now: Instant) -> Float[Array, "3 3"]:
    assert now.axes is not None  # for the type checker: a tree in space has them
    return now.axes


def _bodies(model: dynamics.Model, now: Instant, names: tuple[str, ...]) -> Float[Array, "body 3"]:
    return now.data.xpos[np.array([model.mujoco.body(name).id for name in names])]
