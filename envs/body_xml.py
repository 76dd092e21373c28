"""Which XML may be a body: what a parser reads, held against one table of elements.

MuJoCo never sees the text itself. It gets what is written anew from the elements that were checked,
so that its parser cannot find in a text what this one has not found.
"""

import re
from collections import Counter
from collections.abc import Mapping
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

LARGEST_TEXT = 2_000_000  # characters; ours: a body is some 5,000, and its text is in every run
MOST_ELEMENTS = 2_000  # ours: our bodies have a hundred
MOST_BODIES = 100  # ours: our bodies have ten, and the engines compile code for each
MOST_DEPTH = 100  # elements inside each other; ours: our bodies have ten
LARGEST = 1e10  # MuJoCo's mjMAXVAL, beyond which it takes a simulation to be unstable

_PLACE = "pos quat axisangle xyaxes zaxis euler"
_MOTOR = (
    "name class group joint jointinparent tendon site refsite cranksite slidersite body "
    "cranklength gear ctrllimited ctrlrange forcelimited forcerange damping armature"
)
_CONSTRAINT = "name class active solref solimp"
_TENDON = (
    "name class group limited range margin actuatorfrclimited actuatorfrcrange springlength "
    "stiffness damping frictionloss armature solreflimit solimplimit solreffriction solimpfriction"
)
# Elements, and the attributes that each may have wherever MuJoCo has it. What is not here is
# refused: what opens files or runs plugins, and what repeats its content or reserves as much memory
# as a number says. What an engine does not simulate is refused where a body is made for it.
ALLOWED: Mapping[str, frozenset[str]] = {
    name: frozenset(attributes.split())
    for name, attributes in {
        "mujoco": "model",
        "compiler": "angle autolimits balanceinertia boundinertia boundmass coordinate eulerseq "
        "fitaabb inertiafromgeom inertiagrouprange settotalmass",
        "option": "timestep gravity wind density viscosity integrator jacobian cone solver "
        "impratio tolerance ls_tolerance noslip_tolerance ccd_tolerance iterations ls_iterations "
        "noslip_iterations ccd_iterations actuatorgroupdisable o_margin o_solref o_solimp "
        "o_friction",
        "flag": "actuation autoreset clampctrl constraint contact damper diagexact energy equality "
        "eulerdamp filterparent frictionloss fwdinv gravity invdiscrete island limit midphase "
        "multiccd nativeccd override refsafe sensor sleep spring warmstart",
        "statistic": "center extent meaninertia meanmass meansize",
        "default": "class",
        "custom": "",
        "numeric": "name data size",
        "asset": "",
        "material": "name class rgba emission specular shininess reflectance metallic roughness",
        "mesh": "name class vertex normal face scale refpos refquat inertia smoothnormal",
        "worldbody": "",
        "body": f"name childclass gravcomp {_PLACE}",
        "frame": f"name childclass {_PLACE}",
        "inertial": f"mass diaginertia fullinertia {_PLACE}",
        "joint": "name class type group pos axis range limited damping stiffness springref ref "
        "springdamper armature frictionloss margin actuatorfrclimited actuatorfrcrange "
        "actuatorgravcomp solreflimit solimplimit solreffriction solimpfriction "
        "joint1 joint2 polycoef active solref solimp "  # of an equality
        "joint coef",  # of a fixed tendon
        "freejoint": "name group",
        "geom": "name class type group size fromto mass density rgba material mesh contype "
        "conaffinity condim friction margin gap priority shellinertia solmix solref solimp "
        "fluidshape fluidcoef adhesion surfacevel geom sidesite "  # the last two are of a tendon
        f"{_PLACE}",
        "site": f"name class type group size fromto rgba material site {_PLACE}",
        "camera": f"name class mode target fovy ipd {_PLACE}",
        "light": "name class mode target type directional castshadow active pos dir attenuation "
        "cutoff exponent ambient diffuse specular",
        "contact": "",
        "exclude": "name body1 body2",
        "pair": "name class geom1 geom2 condim friction solref solreffriction solimp margin gap "
        "adhesion",
        "equality": "",
        "connect": f"{_CONSTRAINT} body1 body2 anchor site1 site2",
        "weld": f"{_CONSTRAINT} body1 body2 anchor relpose torquescale site1 site2",
        "tendon": f"{_CONSTRAINT} tendon1 tendon2 polycoef",  # of an equality
        "fixed": _TENDON,
        "spatial": f"{_TENDON} width rgba",
        "pulley": "divisor",
        "actuator": "",
        "motor": _MOTOR,
        "position": f"{_MOTOR} kp kv dampratio timeconst inheritrange",
        "velocity": f"{_MOTOR} kv",
        "general": f"{_MOTOR} dyntype gaintype biastype dynprm gainprm biasprm actlimited actrange "
        "actearly lengthrange",
        "keyframe": "",
        "key": "name time qpos qvel act ctrl",
    }.items()
}
_ONE_TEXT = "a run keeps the text of one file only"
# What whoever writes one of these elements or attributes may do instead.
INSTEAD: Mapping[str, str] = {
    "include": f"{_ONE_TEXT}; write in what is included",
    "attach": f"{_ONE_TEXT}; write in what is attached",
    "file": f"{_ONE_TEXT}; draw with capsules, boxes and spheres, or write a mesh's vertices here",
    "replicate": "write out what it repeats",
    "size": "MuJoCo finds the sizes by itself; remove it",
}
# Attributes that are names, in which nothing is a number.
_NAMES = frozenset(
    "model name class childclass joint joint1 joint2 jointinparent body body1 body2 site site1 "
    "site2 refsite cranksite slidersite sidesite geom geom1 geom2 tendon tendon1 tendon2 target "
    "material mesh".split()
)
_WORD = re.compile(r"(?!nan|inf)[a-z][a-z0-9_]*", re.IGNORECASE)
# Nothing is taken back: a long word that is no number is refused in as much time as it is long.
_NUMBER = re.compile(r"[+-]?([0-9]++\.?[0-9]*+|\.[0-9]++)(e[+-]?[0-9]++)?", re.IGNORECASE)
# What a number of these may be at most, since it says how much memory or time is taken; ours.
_MOST: Mapping[tuple[str, str], float] = {
    ("numeric", "size"): 1_000,
    **{("option", f"{kind}iterations"): 1_000 for kind in ("", "ls_", "noslip_", "ccd_")},
}
_LONGEST_NAME = 100  # characters; ours: complaints quote it


def checked(text: str) -> str:
    """Returns a body's XML, written anew from its elements, without comments.

    Raises:
      ValueError: it is no XML, or holds what no body may; the message names element and line.
    """
    if len(text) > LARGEST_TEXT:
        raise ValueError(
            f"has {len(text):,} characters, and a body may have {LARGEST_TEXT:,}; leave out meshes"
        )
    reader = _Reader()
    try:
        return reader.read(_without_comments(text))
    except expat.ExpatError as error:
        raise ValueError(f"is no XML ({error}); write MJCF, MuJoCo's own format") from None


class _Reader:
    """Checks elements as they are read, and writes them anew."""

    def __init__(self) -> None:
        # The text is decoded already, whatever it says that its encoding is.
        self._parser = expat.ParserCreate("utf-8")
        # Entities are declared in a DOCTYPE: without one none opens a file or grows.
        self._parser.StartDoctypeDeclHandler = self._doctype
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._characters
        self._depth = 0
        self._num: Counter[str] = Counter()
        self._written: list[str] = []
        self._line = 1

    def read(self, text: str) -> str:
        """Returns the text written anew."""
        self._parser.Parse(text.encode("utf-8", "surrogatepass"), True)
        return "".join(self._written)

    def _refusal(self, what: str) -> ValueError:
        return ValueError(f"line {self._parser.CurrentLineNumber}: {what}")

    def _doctype(self, *_: object) -> None:
        raise self._refusal("a body may have no DOCTYPE, which may lead to other files; remove it")

    def _characters(self, data: str) -> None:
        if data.strip():
            raise self._refusal(f"the text {data.strip()[:20]!r} is in no attribute; remove it")

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        self._num.update([name])
        if name not in ALLOWED:
            raise self._refusal(f"a body may have no <{name}>: {INSTEAD.get(name, 'remove it')}")
        if (name == "mujoco") != (self._depth == 1):
            raise self._refusal(f"<{name}> is not in its place; <mujoco> holds all else")
        if self._depth > MOST_DEPTH:
            raise self._refusal(f"<{name}> is inside of {MOST_DEPTH} elements; nest fewer")
        if self._num.total() > MOST_ELEMENTS or self._num["body"] > MOST_BODIES:
            raise self._refusal(
                f"<{name}> is one too many; a body may have {MOST_ELEMENTS:,} elements, and "
                f"{MOST_BODIES} of them <body>"
            )
        for attribute, value in attributes.items():
            self._check(name, attribute, value)
        shown = "".join(f" {each}={quoteattr(value)}" for each, value in attributes.items())
        self._write(f"<{name}{shown}>")

    def _end(self, name: str) -> None:
        self._depth -= 1
        self._write(f"</{name}>")

    def _write(self, tag: str) -> None:
        """Puts a tag into the line where it was read, which MuJoCo's complaints name."""
        line = self._parser.CurrentLineNumber
        self._written.append("\n" * (line - self._line) + tag)
        self._line = line

    def _check(self, name: str, attribute: str, value: str) -> None:
        """Raises ValueError unless the element may have the attribute with such a value."""
        if attribute not in ALLOWED[name]:
            instead = INSTEAD.get(attribute, "remove it")
            raise self._refusal(f"<{name}> may have no {attribute}: {instead}")
        if attribute in _NAMES:
            if len(value) > _LONGEST_NAME:
                raise self._refusal(
                    f"<{name}> has {len(value):,} characters in {attribute}; write at most "
                    f"{_LONGEST_NAME}"
                )
            return
        most = _MOST.get((name, attribute), LARGEST)
        for word in value.split():
            if _WORD.fullmatch(word):
                continue
            if not _NUMBER.fullmatch(word) or abs(float(word)) > most:
                raise self._refusal(
                    f"<{name}> has {word[:20]} in {attribute}; write numbers of at most {most:g}"
                )


def _without_comments(text: str) -> str:
    """Returns the text without comments, its lines numbered as before.

    XML has no `--` in comments; MuJoCo and people do.
    """
    parts: list[str] = []
    at = 0
    while (start := text.find("<!--", at)) >= 0 and (end := text.find("-->", start + 4)) >= 0:
        parts += [text[at:start], "\n" * text.count("\n", start, end)]
        at = end + 3
    return "".join([*parts, text[at:]])
