"""What of a tree of bodies is constant: how its joints follow each other, and their inertias.

Bodies without joints move with those that carry them, so only links are moved: bodies with joints.
Each link has a point of its own, where its last joint turns; places on what the link carries are
measured from there.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.envs import frames
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.derived.source import joints_of

FREE, BALL, SLIDE, HINGE = (
    int(each)
    for each in (
        mujoco.mjtJoint.mjJNT_FREE,
        mujoco.mjtJoint.mjJNT_BALL,
        mujoco.mjtJoint.mjJNT_SLIDE,
        mujoco.mjtJoint.mjJNT_HINGE,
    )
)
ROOT = 1  # number of the body that carries the others
WORLD = -1  # in place of a link's number


class Joint(NamedTuple):
    """A joint of a link.

    Attributes:
      kind: as MuJoCo numbers it.
      position: place of its first coordinate in `qpos`.
      dof: place of its first degree of freedom.
      axis: of a slide or hinge, in the link's axes.
      offset: from the point before to where it turns, in the axes before it turns, m.
      zero: of its coordinate, m or rad.
    """

    kind: int
    position: int
    dof: int
    axis: Float[np.ndarray, "3"]
    offset: Float[np.ndarray, "3"]
    zero: float


class Inertia(NamedTuple):
    """Mass of a link and of what is fixed to it.

    Attributes:
      mass: kg.
      centre: of mass, from the link's point in its axes, m.
      moments: second moments of mass about the centre along `axes`, kg m^2.
      axes: columns in the link's axes.
    """

    mass: float
    centre: Float[np.ndarray, "3"]
    moments: Float[np.ndarray, "3"]
    axes: Float[np.ndarray, "3 3"]


_NOTHING = Inertia(0.0, np.zeros(3), np.zeros(3), np.eye(3))


class Link(NamedTuple):
    """A body with joints.

    Attributes:
      parent: number of the link that carries it, or `WORLD`.
      offset: from the parent's point to the first joint's, in the parent's axes, m.
      quat: by which it is turned in the parent's axes before its joints turn it.
      joints: in their order.
      inertia: of all that moves with it.
      dofs: of all joints that move it, the root's first.
    """

    parent: int
    offset: Float[np.ndarray, "3"]
    quat: Float[np.ndarray, "4"]
    joints: tuple[Joint, ...]
    inertia: Inertia
    dofs: tuple[int, ...]


class Fixed(NamedTuple):
    """Where a body is on the link that it moves with, or in the world.

    Attributes:
      link: its number, or `WORLD`.
      place: from the link's point, in its axes, m.
      quat: by which the body is turned in them.
    """

    link: int
    place: Float[np.ndarray, "3"]
    quat: Float[np.ndarray, "4"]


class Layout(NamedTuple):
    """A tree of links: constants only.

    Attributes:
      links: parents before children.
      bodies: where each body is fixed, by its number.
      num_dofs: degrees of freedom of all.
    """

    links: tuple[Link, ...]
    bodies: tuple[Fixed, ...]
    num_dofs: int


def of_model(model: Any) -> Layout:
    """Returns the layout of a `mujoco.MjModel` of one tree."""
    links: list[Link] = []
    bodies = [Fixed(WORLD, np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))]
    for body in range(1, model.nbody):
        carrier = bodies[model.body_parentid[body]]
        place = carrier.place + frames.matrix(carrier.quat) @ model.body_pos[body]
        quat = _product(carrier.quat, model.body_quat[body])
        joints = joints_of(model, body)
        if not joints:
            bodies.append(Fixed(carrier.link, place, quat))
            continue
        dofs = links[carrier.link].dofs if carrier.link != WORLD else ()
        first = model.body_dofadr[body]
        dofs += tuple(range(first, first + model.body_dofnum[body]))
        anchors = [np.array(model.jnt_pos[joint]) for joint in joints]
        before = [anchors[0], *anchors[:-1]]
        link = Link(
            parent=carrier.link,
            offset=frames.clean(place + frames.matrix(quat) @ anchors[0]),
            quat=quat,
            joints=tuple(
                _joint(model, joint, anchor - last)
                for joint, anchor, last in zip(joints, anchors, before, strict=True)
            ),
            inertia=_NOTHING,
            dofs=dofs,
        )
        bodies.append(Fixed(len(links), -anchors[-1], np.array([1.0, 0.0, 0.0, 0.0])))
        links.append(link)
    found = [
        link._replace(
            inertia=_inertia(model, [b for b, at in enumerate(bodies) if at.link == n], bodies)
        )
        for n, link in enumerate(links)
    ]
    return Layout(tuple(found), tuple(bodies), int(model.nv))


def _joint(model: Any, joint: int, offset: Float[np.ndarray, "3"]) -> Joint:
    position = int(model.jnt_qposadr[joint])
    return Joint(
        kind=int(model.jnt_type[joint]),
        position=position,
        dof=int(model.jnt_dofadr[joint]),
        axis=frames.clean(np.array(model.jnt_axis[joint])),
        offset=frames.clean(offset),
        zero=float(model.qpos0[position]),
    )


def _inertia(model: Any, bodies: list[int], fixed: list[Fixed]) -> Inertia:
    """Returns the inertia of bodies that are fixed to one link."""
    masses = np.array([model.body_mass[body] for body in bodies])
    total = masses.sum()
    if not total:
        return _NOTHING
    turns = [frames.matrix(fixed[body].quat) for body in bodies]
    centres = np.array(
        [
            fixed[body].place + turn @ model.body_ipos[body]
            for body, turn in zip(bodies, turns, strict=True)
        ]
    )
    centre = masses @ centres / total
    if len(bodies) == 1:
        inertia = np.array(model.body_inertia[bodies[0]])
        moments = 0.5 * inertia.sum() - inertia
        axes = turns[0] @ frames.matrix(model.body_iquat[bodies[0]])
        return Inertia(total, frames.clean(centre), moments, frames.clean(axes))
    second = np.zeros((3, 3))
    for body, turn, mass, own in zip(bodies, turns, masses, centres, strict=True):
        axes = turn @ frames.matrix(model.body_iquat[body])
        inertia = np.array(model.body_inertia[body])
        second += axes @ np.diag(0.5 * inertia.sum() - inertia) @ axes.T
        second += mass * np.outer(own - centre, own - centre)
    moments, axes = np.linalg.eigh(second)
    return Inertia(total, frames.clean(centre), moments, frames.clean(axes))


def _product(one: Float[np.ndarray, "4"], other: Float[np.ndarray, "4"]) -> Float[np.ndarray, "4"]:
    found = np.zeros(4)
    mujoco.mju_mulQuat(found, np.array(one), np.array(other))
    return found
