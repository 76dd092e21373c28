"""A tree of bodies that floats in space, seen from its root.

How a tree moves depends on where it is and how it is turned only through gravity and the ground. So
its kinematics take axes that stand still but coincide with the root's at this instant: the root's
own rows and columns are then constants, and each hinge turns two axes. The root's attitude is given
by Euler's angles, z-y-x: yaw about the vertical, then pitch about y, then roll about x.
"""

from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.envs import frames
from mjxwalk.envs._mujoco import mjx
from mjxwalk.envs.anatomy import SLIDE
from mjxwalk.envs.dynamics import Model, PointMass, with_mass
from mjxwalk.envs.frames import Frame, X, Y, Z


def freed(spec: Any, root: str) -> Any:
    """Returns the `mujoco.MjSpec` with the root body's joints replaced by a free joint."""
    for joint in spec.body(root).joints:
        spec.delete(joint)
    spec.body(root).add_freejoint()
    return spec


def rotation(euler: Float[Array, "3"]) -> Float[Array, "3 3"]:
    """Returns the matrix that takes the root's axes to the world's, of yaw, pitch and roll."""
    frame = frames.identity()
    for axis, angle in zip((Z, Y, X), euler, strict=True):
        frame = frames.turned(frame, axis, angle)
    return jnp.stack(frame, axis=1)


def spin(euler: Float[Array, "3"], rates: Float[Array, "3"]) -> Float[Array, "3"]:
    """Returns the root's angular velocity in its own axes, rad/s, of the angles' rates."""
    _, pitch, roll = euler
    yaw_rate, pitch_rate, roll_rate = rates
    level = yaw_rate * jnp.cos(pitch)
    sine, cosine = jnp.sin(roll), jnp.cos(roll)
    return jnp.stack(
        [
            roll_rate - yaw_rate * jnp.sin(pitch),
            cosine * pitch_rate + sine * level,
            cosine * level - sine * pitch_rate,
        ]
    )


def euler_acceleration(
    euler: Float[Array, "3"], rates: Float[Array, "3"], acceleration: Float[Array, "3"]
) -> Float[Array, "3"]:
    """Returns the angles' second derivatives, of the angular acceleration in the root's axes.

    They solve the derivative of `spin`; at a pitch of a right angle they are infinite.
    """
    _, pitch, roll = euler
    yaw_rate, pitch_rate, roll_rate = rates
    sine, cosine = jnp.sin(roll), jnp.cos(roll)
    level, tilt = yaw_rate * jnp.cos(pitch), yaw_rate * jnp.sin(pitch)
    # spin's second and third row are (pitch_rate, level), turned by the roll.
    across = cosine * acceleration[1] - sine * acceleration[2] - roll_rate * level
    upward = sine * acceleration[1] + cosine * acceleration[2] + roll_rate * pitch_rate
    yaw = (upward + tilt * pitch_rate) / jnp.cos(pitch)
    forward = acceleration[0] + yaw * jnp.sin(pitch) + level * pitch_rate
    return jnp.stack([yaw, across, forward])


def forward(
    model: Model,
    angles: Float[Array, " joint"],
    qvel: Float[Array, " nv"],
    gravity: Float[Array, "3"],
    carried: PointMass | None = None,
) -> Any:
    """Returns `mjx.Data` with positions, velocities and bias forces in the root's axes.

    Spatial vectors refer to the root's origin, which `subtree_com` says too.

    Args:
      model: a tree with a free root, and hinges and slides elsewhere.
      angles: of the hinges, rad, and of the slides, m.
      qvel: the root's velocity and angular velocity in its axes, then the hinges' rates.
      gravity: in the root's axes, m/s^2.
      carried: is part of the tree's inertia.
    """
    xpos, xmat, cdof = _place(model.mujoco, angles)
    data = model.data.replace(qvel=qvel, xpos=xpos, xmat=xmat, cdof=cdof)
    data = data.replace(subtree_com=jnp.zeros_like(xpos))
    data = data.tree_replace({"_impl.cinert": _inertias(model.mujoco, xpos, xmat)})
    data = mjx.com_vel(model.mjx, with_mass(data, carried))
    return mjx.rne(model.mjx.tree_replace({"opt.gravity": gravity}), data)


def forward_from_euler(
    model: Model,
    qpos: Float[Array, " joint"],
    qvel: Float[Array, " joint"],
    axes: Float[Array, "3 3"],
    gravity: float,
    carried: PointMass | None = None,
) -> Any:
    """Returns the same of a root whose coordinates are its place and `rotation`'s angles.

    Args:
      model: as `forward` takes it.
      qpos: of the root's six joints, then of the hinges.
      qvel: their rates.
      axes: the root's, from `rotation`.
      gravity: downwards, m/s^2.
      carried: as `forward` takes it.
    """
    turning = spin(qpos[3:6], qvel[3:6])
    rates = jnp.concatenate([qvel[:3] @ axes, turning, qvel[6:]])
    return forward(model, qpos[6:], rates, -gravity * axes[2], carried)


def _place(
    m: Any, angles: Float[Array, " joint"]
) -> tuple[Float[Array, "body 3"], Float[Array, "body 3 3"], Float[Array, "nv 6"]]:
    """Returns all bodies' positions and orientations, and each degree of freedom's motion."""
    places: list[Array] = [jnp.zeros(3)] * 2  # the world's is never read
    turns: list[Frame] = [frames.identity()] * 2
    motions = [jnp.eye(6)[3:], jnp.eye(6)[:3]]
    for body in range(2, m.nbody):
        parent = m.body_parentid[body]
        place = places[parent] + frames.along(turns[parent], m.body_pos[body])
        frame = frames.fixed(turns[parent], m.body_quat[body])
        first = m.body_jntadr[body]
        for joint in range(first, first + m.body_jntnum[body]):
            axis, moved = frames.along(frame, m.jnt_axis[joint]), angles[joint - 1]
            if m.qpos0[m.jnt_qposadr[joint]]:
                moved = moved - float(m.qpos0[m.jnt_qposadr[joint]])
            if int(m.jnt_type[joint]) == SLIDE:
                motions.append(jnp.concatenate([jnp.zeros(3), axis])[None])
                place = place + moved * axis
                continue
            anchor = place + frames.along(frame, m.jnt_pos[joint])
            motions.append(jnp.concatenate([axis, jnp.cross(anchor, axis)])[None])
            frame = frames.turned(frame, m.jnt_axis[joint], moved)
            if m.jnt_pos[joint].any():
                place = anchor - frames.along(frame, m.jnt_pos[joint])
        places.append(place)
        turns.append(frame)
    xmat = jnp.stack([jnp.stack(frame, axis=1) for frame in turns])
    return jnp.stack(places), xmat, jnp.concatenate(motions)


def _inertias(
    m: Any, xpos: Float[Array, "body 3"], xmat: Float[Array, "body 3 3"]
) -> Float[Array, "body 10"]:
    """Returns spatial inertias about the origin: xx yy zz xy xz yz, m x, m y, m z, m."""
    rows = [jnp.zeros(10)]
    for body in range(1, m.nbody):
        mass, (a, b, c) = m.body_mass[body], m.body_inertia[body]
        x, y, z = xmat[body].T
        centre = xpos[body] + frames.along((x, y, z), m.body_ipos[body])
        if m.body_iquat[body][0] != 1.0:
            x, y, z = (
                frames.along((x, y, z), axis) for axis in frames.matrix(m.body_iquat[body]).T
            )
        # x x' + y y' + z z' = 1 saves the third axis.
        outer = (c - a) * x[:, None] * x + (c - b) * y[:, None] * y
        outer += mass * centre[:, None] * centre
        own = c + mass * jnp.sum(centre**2) - jnp.diag(outer)
        apart = -jnp.stack([outer[0, 1], outer[0, 2], outer[1, 2]])
        rows.append(jnp.concatenate([own, apart, mass * centre, jnp.full(1, mass)]))
    return jnp.stack(rows)
