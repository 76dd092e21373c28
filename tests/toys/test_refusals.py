"""A file that is no body for `MjcfEnv` is refused in one sentence, before anything is simulated."""

from pathlib import Path

import pytest

from mjxwalk.envs import MjcfEnv

XML = Path(__file__).with_name("toy_biped.xml").read_text(encoding="utf-8")
REFUSED = {
    "a motor of the root": ('<motor joint="hip_left"/>', '<motor joint="root_x"/>', "the root"),
    "another gravity": ("<default>", '<option gravity="0 0 -1"/><default>', "gravity"),
    "a root without a slide": (
        '<joint name="root_y" type="slide" axis="0 1 0" damping="0"/>',
        "",
        "trunk moves by 2 slides and 3 hinges alone",
    ),
    "a second body in the world": (
        "<worldbody>",
        '<worldbody><body name="box"><geom type="sphere" size="0.1"/></body>',
        "lies beside box",
    ),
    "a body that MuJoCo cannot compile": ('mass="1.5"', 'mass="-1"', "mass"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_what_cannot_walk_is_refused(kind: str) -> None:
    old, new, words = REFUSED[kind]
    assert old in XML
    with pytest.raises(ValueError, match=words) as refused:
        MjcfEnv(body=XML.replace(old, new, 1))
    assert "\n" not in str(refused.value)
