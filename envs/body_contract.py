"""What a file must hold to be a body that we can simulate, as data."""

from typing import NamedTuple


class Joint(NamedTuple):
    """A joint that a body must have.

    Attributes:
      name: of the joint.
      kind: SLIDE or HINGE.
      axis: in its body, a unit vector.
    """

    name: str
    kind: int
    axis: tuple[int, int, int]


class Link(NamedTuple):
    """A body of the tree that must be there.

    Attributes:
      name: of the body.
      parent: its name; "world" of the first.
      joints: in this order; () of a body that is fixed to its parent.
      hangs: whether it lies straight below its parent's origin in the plane; None where it may lie
        anywhere.
    """

    name: str
    parent: str
    joints: tuple[Joint, ...]
    hangs: bool | None = None


class Contract(NamedTuple):
    """What a file must hold to be a body.

    Attributes:
      kind: of the body, in a word.
      links: parents first.
      sites: each that touches the ground, and the body that carries it.
      motors: joints that may have one.
      tied: two joints that may be tied to be equal, since the body has them so.
    """

    kind: str
    links: tuple[Link, ...]
    sites: tuple[tuple[str, str], ...]
    motors: tuple[str, ...]
    tied: tuple[str, str] | None = None
