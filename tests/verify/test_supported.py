"""Tests of what is refused: whatever of a body has no second law."""

import dataclasses
from typing import Any

import pytest
from verify.stepped import BODIES, TOY

from mjxwalk.envs import Flame, MjcfEnv, Planar7, Reil, SoftContact
from mjxwalk.envs.anatomy import Sense
from mjxwalk.verify import supported


@pytest.mark.parametrize("name", BODIES)
def test_bodies_are_supported(name: str) -> None:
    supported.check("a walker", BODIES[name])


def test_a_body_is_known_by_what_it_says_and_not_by_its_class() -> None:
    class Other(Planar7):
        """A body of somebody else's."""

    supported.check("a walker", Other())


class Carrying(Planar7):
    """A body that carries something, and does not say what."""

    def carried(self, state: Any, now: Any, given: Any, /) -> Any:
        return {}


class Unsaid(Reil):
    """A body whose own laws are those of its parent, which has other motors."""

    def drive(self, state: Any, action: Any, now: Any, loads: Any) -> Any:
        raise NotImplementedError


class Strange(Flame):
    """A body with a law that nobody knows."""

    def own_laws(self) -> dict[str, tuple[Any, ...]]:
        return {**super().own_laws(), "carried": (3.0,)}


class Sensing(Planar7):
    """A body that senses what no coordinate says."""

    @property
    def anatomy(self) -> Any:
        found = super().anatomy
        return found._replace(senses=(*found.senses, Sense("light", "lx", "of the sun")))


class Speedy(Planar7):
    """A body whose motors go by velocity, by a law that is not told."""

    @property
    def anatomy(self) -> Any:
        found = super().anatomy
        return found._replace(motors=[each._replace(law="velocity") for each in found.motors])


class Sticky(SoftContact):
    """Ground of another law."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Moon:
    """Ground of another shape."""

    roughness: float = 0.0
    num_nodes: int = 1


@pytest.mark.parametrize(
    ("env", "missing"),
    [
        (Carrying(), "the method `carried`, which `own_laws` should tell of, of Carrying"),
        (Unsaid(), "the method `drive`, which `own_laws` should tell of, of Unsaid"),
        (Strange(), "the law float in `carried` of Strange"),
        (Sensing(), "the sense light of Sensing"),
        (Speedy(), "motors by velocity, whose VelocityMotor `own_laws` should have, of Speedy"),
        (Planar7(contact=Sticky()), "the contact Sticky of Planar7"),
        (MjcfEnv(body=TOY, terrain=Moon()), "the ground Moon of MjcfEnv"),
    ],
    ids=lambda each: each if isinstance(each, str) else type(each).__name__,
)
def test_what_has_no_second_law_is_refused(env: Any, missing: str) -> None:
    with pytest.raises(ValueError) as refused:
        supported.check("my walker", env)
    expected = f"my walker cannot be verified, as there is no second law for {missing}"
    assert str(refused.value) == expected


def test_what_is_no_legged_environment_is_refused() -> None:
    with pytest.raises(ValueError, match="as its body object is no LeggedEnv"):
        supported.check("my walker", object())
