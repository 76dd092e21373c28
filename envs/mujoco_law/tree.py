"""Where a tree of links is, how it moves, and what it takes to move it otherwise.

All is seen from the root's place in the world's axes. A free root's turning counts about these axes
too, so that its rows of all matrices are those of a rigid body and cost nothing. Spatial vectors
have the turning part first.
"""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import frames
from mjxwalk.envs.frames import Frame
from mjxwalk.envs.mujoco_law.layout import BALL, FREE, SLIDE, WORLD, Joint, Layout, Link


class Tree(NamedTuple):
    """A tree at an instant.

    Attributes:
      layout: what is constant of it.
      origin: the root's place in the world, m.
      turns: each link's axes, as columns.
      places: of each link's point from the root's place, m.
      motions: velocities there that a degree of freedom gives to what it moves.
      steps: of each joint, from the point before it to where it turns, or slides to, m.
    """

    layout: Layout
    origin: Float[Array, "3"]
    turns: Float[Array, "link 3 3"]
    places: Float[Array, "link 3"]
    motions: Float[Array, "dof 6"]
    steps: tuple[tuple[Float[Array, "3"], ...], ...]


def of_positions(layout: Layout, qpos: Float[Array, " nq"]) -> Tree:
    """Returns where a tree is.

    Args:
      layout: of the model.
      qpos: positions; a quaternion may have any length.
    """
    turns: list[Frame] = []
    places: list[Array] = []
    motions: list[Array] = [jnp.zeros(6)] * layout.num_dofs
    steps: list[tuple[Array, ...]] = []
    origin = jnp.zeros(3)
    for link in layout.links:
        is_root = link.parent == WORLD
        frame = frames.identity() if is_root else turns[link.parent]
        start = jnp.zeros(3) if is_root else places[link.parent]
        moved = _moved(link, frame, qpos)
        place = sum((each.step for each in moved), start=start)
        if is_root:
            # Where the root is, which all is seen from, is known only now.
            origin, place = place, jnp.zeros(3)
            start = start - origin
        for joint, each in zip(link.joints, moved, strict=True):
            start = start + each.step
            for number, motion in enumerate(_motions(joint, each.axes, start)):
                motions[joint.dof + number] = motion
        turns.append(moved[-1].frame)
        places.append(place)
        steps.append(tuple(each.step for each in moved))
    return Tree(
        layout,
        origin,
        jnp.stack([jnp.stack(frame, axis=1) for frame in turns]),
        jnp.stack(places),
        jnp.stack(motions),
        tuple(steps),
    )


class _Moved(NamedTuple):
    """What a joint does to a link.

    Attributes:
      step: from the point before to where it turns or slides to, m.
      axes: those that it turns about, or slides along, are given in.
      frame: the link's axes behind it.
    """

    step: Float[Array, "3"]
    axes: Frame
    frame: Frame


def _moved(link: Link, carrier: Frame, qpos: Float[Array, " nq"]) -> list[_Moved]:
    """Returns what each joint of a link does, given the axes of what carries it."""
    frame, step = _fixed(carrier, link.quat), frames.along(carrier, link.offset)
    found: list[_Moved] = []
    for joint in link.joints:
        if joint.offset.any():
            step = step + frames.along(frame, joint.offset)
        axes, at = frame, joint.position
        if joint.kind == FREE:
            step = qpos[at : at + 3]
            axes = frame = of_quaternion(qpos[at + 3 : at + 7])
        elif joint.kind == BALL:
            axes = frame = _by(frame, of_quaternion(qpos[at : at + 4]))
        elif joint.kind == SLIDE:
            step = step + (qpos[at] - joint.zero) * frames.along(frame, joint.axis)
        else:
            axes = frame = frames.turned(frame, joint.axis, qpos[at] - joint.zero)
        found.append(_Moved(step, axes, frame))
        step = jnp.zeros(3)
    return found


def about_world(tree: Tree, own: Float[Array, " dof"]) -> Float[Array, " dof"]:
    """Returns velocities, or accelerations, as a tree counts them, of those that MuJoCo counts.

    MuJoCo has a free root's turning about the root's axes.
    """
    return _root_turned(tree, own, tree.turns[0])


def about_root(tree: Tree, seen: Float[Array, " dof"]) -> Float[Array, " dof"]:
    """Returns velocities, or accelerations, as MuJoCo counts them; the inverse of `about_world`."""
    return _root_turned(tree, seen, tree.turns[0].T)


def _root_turned(
    tree: Tree, values: Float[Array, " dof"], turn: Float[Array, "3 3"]
) -> Float[Array, " dof"]:
    root = tree.layout.links[0].joints[0]
    if root.kind != FREE:
        return values
    places = slice(root.dof + 3, root.dof + 6)
    return values.at[places].set(turn @ values[places])


def _motions(joint: Joint, frame: Frame, place: Float[Array, "3"]) -> list[Array]:
    nothing = jnp.zeros(3)
    if joint.kind == FREE:
        return [*jnp.eye(6)[3:], *jnp.eye(6)[:3]]
    if joint.kind == BALL:
        return [jnp.concatenate([axis, jnp.cross(place, axis)]) for axis in frame]
    axis = frames.along(frame, joint.axis)
    if joint.kind == SLIDE:
        return [jnp.concatenate([nothing, axis])]
    return [jnp.concatenate([axis, jnp.cross(place, axis)])]


def of_quaternion(quat: Float[Array, "4"]) -> Frame:
    """Returns the axes that a quaternion of any length turns to, w first."""
    w, x, y, z = quat
    x2, y2, z2 = 2.0 / (quat @ quat) * quat[1:]
    xx, yy, zz = x2 * x, y2 * y, z2 * z
    wx, wy, wz = x2 * w, y2 * w, z2 * w
    xy, xz, yz = x2 * y, x2 * z, y2 * z
    return (
        jnp.stack([1.0 - yy - zz, xy + wz, xz - wy]),
        jnp.stack([xy - wz, 1.0 - xx - zz, yz + wx]),
        jnp.stack([xz + wy, yz - wx, 1.0 - xx - yy]),
    )


def _by(frame: Frame, own: Frame) -> Frame:
    """Returns axes that are given in a frame."""
    x, y, z = (each[0] * frame[0] + each[1] * frame[1] + each[2] * frame[2] for each in own)
    return x, y, z


def _fixed(frame: Frame, quat: Float[np.ndarray, "4"]) -> Frame:
    if abs(quat[0]) == 1.0:
        return frame
    x, y, z = (frames.along(frame, axis) for axis in frames.clean(frames.matrix(quat)).T)
    return x, y, z
