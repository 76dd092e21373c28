"""Tests of the door that a body's XML comes through: what passes, and that nothing else does."""

import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mjxwalk.envs import body_file, body_xml
from mjxwalk.envs._mujoco import compiled as compiled_body
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.bodies import flame_body, planar7_body, reil_body

CHILD = (Path(__file__).parents[2] / "docs/bodies/child.xml").read_text()
SHIPPED = {
    "planar7": planar7_body.MODEL_PATH.read_text(),
    "flame": flame_body.MODEL_PATH.read_text(),
    "reil": reil_body.MODEL_PATH.read_text(),
    "child": CHILD,
}
INSIDE = '<body name="head"'  # in the child's torso


def compiled(text: str) -> dict[str, Any]:
    """Returns the arrays that MuJoCo makes of a text."""
    model = mujoco.MjSpec.from_string(text).compile()
    named = ((name, getattr(model, name)) for name in dir(model) if not name.startswith("_"))
    return {name: value for name, value in named if isinstance(value, np.ndarray)}


def elements(text: str) -> str:
    """Returns what is written anew of a text, whatever lines it stands in."""
    return body_xml.checked(text).replace("\n", "")


@pytest.mark.parametrize("name", SHIPPED)
def test_what_is_written_anew_is_the_same_body(name: str) -> None:
    as_it_is, anew = compiled(SHIPPED[name]), compiled(body_xml.checked(SHIPPED[name]))
    assert len(anew) > 300
    for field, value in as_it_is.items():
        np.testing.assert_array_equal(value, anew[field], err_msg=field)


@pytest.mark.parametrize(
    "comment",
    [
        '<!-- <include file="scene.xml"/> -->',
        '<!-- once --body <INCLUDE file="a"/> -- twice -->\n<!---->',
        "<!-- <!-- -->",
    ],
)
def test_a_comment_says_nothing(comment: str) -> None:
    assert elements(f"{comment}{CHILD}") == elements(CHILD)
    inside = CHILD.replace("<worldbody>", f"<worldbody>{comment}")
    assert elements(inside) == elements(CHILD)


def test_what_follows_a_comment_is_read() -> None:
    for text in ("<!-- --><include file='a'/>", "<!-- -- --><include file='a'/><!-- -->"):
        with pytest.raises(ValueError, match="no <include>"):
            body_xml.checked(f"<mujoco>{text}</mujoco>")


# Elements of MuJoCo's that open files or run plugins, repeat what is in them, or reserve memory.
HARMFUL = {
    "include": ('<include file="x.xml"/>', "no <include>"),
    "capitals": ('<INCLUDE file="x.xml"/>', "no <INCLUDE>"),
    "prefix": ('<m:include xmlns:m="a" file="x.xml"/>', "no <m:include>"),
    "flexcomp": ('<flexcomp name="f" type="mesh" file="x.obj"/>', "no <flexcomp>"),
    "attach": ('<attach model="m" body="b" prefix="p"/>', "no <attach>"),
    "composite": ('<composite type="cable" count="9999 1 1"/>', "no <composite>"),
    "replicate": ('<replicate count="9999"><site/></replicate>', "no <replicate>"),
    "plugin": ('<plugin plugin="mujoco.sdf.bowl"/>', "no <plugin>"),
    "hfield": ('<geom type="hfield" hfield="h"/>', "<geom> may have no hfield"),
    "mocap": ('<body mocap="true"/>', "<body> may have no mocap"),
    "text": ("include", "the text 'include' is in no attribute"),
    "cdata": ('<![CDATA[<include file="x.xml"/>]]>', "is in no attribute"),
}
SECTIONS = {
    "model": ('<asset><model name="m" file="x.xml"/></asset>', "no <model>"),
    "mesh": ('<asset><mesh file="x.stl"/></asset>', "<mesh> may have no file"),
    "sphere": ('<asset><mesh builtin="sphere" params="99"/></asset>', "may have no builtin"),
    "texture": (
        '<asset><texture type="2d" builtin="flat" width="20000" height="20000"/></asset>',
        "no <texture>",
    ),
    "height field": ('<asset><hfield file="x.png" size="1 1 1 1"/></asset>', "no <hfield>"),
    "skin": ('<deformable><skin file="x.skn"/></deformable>', "no <deformable>"),
    "size": ('<size nkey="100000000"/>', "no <size>"),
    "memory": ('<size memory="1000G"/>', "no <size>"),
    "tupled": ('<custom><tuple name="t"/></custom>', "no <tuple>"),
    "iterations": ('<option iterations="1000000"/>', "has 1000000 in iterations"),
    "act": ('<actuator><general joint="a" actdim="99999999"/></actuator>', "may have no actdim"),
    "muscle": ('<actuator><muscle joint="a"/></actuator>', "no <muscle>"),
    "meshdir": ('<compiler meshdir="/etc"/>', "<compiler> may have no meshdir"),
    "numeric": ('<custom><numeric name="n" size="1000000000"/></custom>', "has 1000000000 in size"),
    "sensor": ('<sensor><jointpos joint="root_x"/></sensor>', "no <sensor>"),
    "buffer": (
        '<actuator><motor joint="a" nsample="999999999"/></actuator>',
        "may have no nsample",
    ),
    "extension": ("<extension/>", "no <extension>"),
    "nested": ("<mujoco/>", "<mujoco> is not in its place"),
}


@pytest.mark.parametrize("case", [*HARMFUL, *SECTIONS])
def test_what_no_body_may_have_is_refused_with_its_line(case: str) -> None:
    if case in HARMFUL:
        added, complaint = HARMFUL[case]
        text = CHILD.replace(INSIDE, f"\n{added}{INSIDE}")
    else:
        added, complaint = SECTIONS[case]
        text = CHILD.replace("</mujoco>", f"{added}</mujoco>")
    line = text.count("\n", 0, text.index(added)) + 1
    with pytest.raises(ValueError, match=f"^line {line}: .*{re.escape(complaint)}"):
        body_xml.checked(text)


@pytest.mark.parametrize("root", ["robot", "mujocoinclude", "MUJOCO"])
def test_only_mujocos_own_format_is_read(root: str) -> None:
    with pytest.raises(ValueError, match=f"^line 1: a body may have no <{root}>"):
        body_xml.checked(f'<{root} name="r"/>')


LAUGHS = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 30))
DOCTYPES = {
    "billion laughs": f'<!DOCTYPE m [<!ENTITY l0 "lol">{LAUGHS}]><mujoco model="&l29;"/>',
    "external entity": '<!DOCTYPE m [<!ENTITY x SYSTEM "file:///etc/passwd">]><mujoco>&x;</mujoco>',
    "external subset": '<!DOCTYPE m SYSTEM "http://localhost/x.dtd"><mujoco/>',
    "parameter": '<!DOCTYPE m [<!ENTITY % x SYSTEM "file:///etc/passwd">%x;]><mujoco/>',
}


@pytest.mark.parametrize("case", DOCTYPES)
def test_no_text_declares_entities(case: str) -> None:
    with pytest.raises(ValueError, match="^line 1: a body may have no DOCTYPE"):
        body_xml.checked(DOCTYPES[case])


@pytest.mark.parametrize("number", ["nan", "-NaN", "inf", "-infinity", "1e999", "nan(7)", "1e11"])
@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('integrator="Euler"', 'timestep="{}"'),
        ('pos="0 0 0.46"', 'pos="0 {} 0.46"'),
        ('mass="12.54"', 'mass="{}"'),
        ('range="0 130"', 'range="0 {}"'),
        ('ctrlrange="-1 1"', 'ctrlrange="-1 {}"'),
        ('damping="0.2"', 'damping="{}"'),
    ],
)
def test_every_number_is_one_to_compute_with(number: str, old: str, new: str) -> None:
    text = CHILD.replace(old, new.format(number))
    assert text != CHILD
    attribute = new.partition("=")[0]
    with pytest.raises(ValueError, match=f"has {re.escape(number)} in {attribute}; write numbers"):
        body_xml.checked(text)


@pytest.mark.parametrize("value", ["0x1p9", "1,2", "1_0", "--1", "1e", "١"])
def test_what_only_one_of_two_parsers_takes_for_a_number_is_refused(value: str) -> None:
    # Python reads 1_0 as ten; MuJoCo does not.
    with pytest.raises(ValueError, match="pos"):
        body_xml.checked(CHILD.replace('pos="0 0 0.46"', f'pos="0 0 {value}"'))


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (CHILD.replace(INSIDE, "<site/>" * 100_000 + INSIDE), "one too many; .* 2,000 elements"),
        (CHILD.replace(INSIDE, "<body/>" * 101 + INSIDE), "100 of them <body>"),
        (f"<mujoco><worldbody>{'<frame>' * 50_000}", "inside of 100 elements"),
        (CHILD.replace(INSIDE, "<!--" * 400_000 + INSIDE), "is no XML"),
        (CHILD.replace("child", "c" * 2_000_000), "a body may have 2,000,000; leave out meshes"),
        (CHILD.replace('"0 0 0.46"', f'"{"1" * 1_000_000}x"'), "has 1{20} in pos"),
        (CHILD.replace('"child"', f'"{"c" * 1_000_000}"'), "1,000,000 characters in model"),
    ],
    ids=["sites", "bodies", "nested", "comments", "long", "digits", "name"],
)
def test_what_would_take_long_is_refused_at_once(text: str, complaint: str) -> None:
    started = time.perf_counter()
    with pytest.raises(ValueError, match=complaint):
        body_xml.checked(text)
    assert time.perf_counter() - started < 2.0


@pytest.mark.parametrize(
    "text", ["", "a walker", "<mujoco", "<mujoco/><mujoco/>", "<mujoco>\0", "\udc80"]
)
def test_what_is_no_xml_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="is no XML"):
        body_xml.checked(text)


def test_mujoco_complains_of_the_line_in_the_file() -> None:
    comments = "<!-- of\nseveral\nlines -->\n"
    text = CHILD.replace(INSIDE, f"{comments}<body name='torso'\n/>{INSIDE}")
    line = 1 + text[: text.index("<body name='torso'")].count("\n")
    with pytest.raises(ValueError, match=f"repeated name 'torso' in body\\s.* line {line}\\b"):
        body_file.read(text)


def test_a_text_is_read_whatever_it_says_of_its_encoding() -> None:
    for said in ("UTF-16", "latin-1", "UTF-8", "no-such"):
        text = f'<?xml version="1.0" encoding="{said}"?>\n{CHILD}'
        assert elements(text) == elements(CHILD)
    assert elements(f"\ufeff{CHILD}") == elements(CHILD)


ODD = ("0", "-1", "1e10", "1e-300", "", "true", "free", "1 2 3", "2147483648", " 9" * 300)


@pytest.mark.parametrize("value", ODD, ids=lambda value: value[:10])
def test_whatever_is_allowed_is_a_body_or_refused(value: str) -> None:
    taken = 0
    for element, attributes in body_xml.ALLOWED.items():
        for attribute in sorted(attributes):
            with_it, num = re.subn(
                rf"<{element}(?=[ />])", f'<{element} {attribute}="{value}"', CHILD
            )
            text = (
                with_it
                if num
                else CHILD.replace(INSIDE, f'<{element} {attribute}="{value}"/>{INSIDE}')
            )
            try:
                compiled_body(body_file.read(text))
                taken += 1
            except ValueError as refusal:
                assert str(refusal)
    assert taken < sum(map(len, body_xml.ALLOWED.values()))
