"""A file that is no body for `MjcfEnv` is refused in one sentence, before anything is simulated."""

from pathlib import Path

import pytest

from mjxwalk.envs import MjcfEnv

XML = Path(__file__).with_name("toy_biped.xml").read_text(encoding="utf-8")
REFUSED = {
    "a root axis turned round": ('type="slide" axis="0 0 1"', 'type="slide" axis="0 0 -1"', "-z"),
    "a tilted root axis": ('type="slide" axis="1 0 0"', 'type="slide" axis="1 0 1"', "root_x"),
    "a motor of the root": ('<motor joint="hip_left"/>', '<motor joint="root_x"/>', "root_x"),
    "two motors on a joint": (
        '<motor joint="hip_left"/>',
        '<motor joint="knee_left"/>',
        "knee_left",
    ),
    "a trunk off the origin": ('<body name="trunk">', '<body name="trunk" pos="0 0 1">', "trunk"),
    "a turned trunk": ('<body name="trunk">', '<body name="trunk" euler="0 30 0">', "turned"),
    "a site without a name": ('<site name="toe_in_left" ', "<site ", "a site has no name"),
    "a ball joint": (
        '<joint name="knee_left" axis="0 1 0"',
        '<joint name="knee_left" type="ball"',
        "ball",
    ),
    "a tilted hinge": ('"knee_left" axis="0 1 0"', '"knee_left" axis="0 1 1"', "knee_left"),
    "a slide as a knee": (
        '"knee_left" axis="0 1 0"',
        '"knee_left" type="slide" axis="0 0 1"',
        "slide",
    ),
    "a joint without a range": ('axis="0 1 0" range="0 90"', 'axis="0 1 0"', "range"),
    "geoms that would collide": ('contype="0" conaffinity="0" ', "", "collide"),
    "another gravity": ("<default>", '<option gravity="0 0 -1"/><default>', "gravity"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_what_no_law_moves_is_refused(kind: str) -> None:
    old, new, words = REFUSED[kind]
    assert old in XML
    with pytest.raises(ValueError, match=words) as refused:
        MjcfEnv(body=XML.replace(old, new, 1))
    assert "\n" not in str(refused.value)


def test_feet_without_sites_are_named() -> None:
    lines = [line for line in XML.splitlines() if "<site" not in line]
    with pytest.raises(ValueError, match="no feet"):
        MjcfEnv(body="\n".join(lines))
