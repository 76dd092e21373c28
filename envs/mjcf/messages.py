"""What MuJoCo says of a file that it cannot take, as one sentence with element and line."""

import re
from collections.abc import Sequence

from mjxwalk.envs.mjcf import lines
from mjxwalk.envs.mjcf.lines import Place

_ELEMENT = re.compile(
    r"\s*Element (?:name )?'(?P<name>[^']*)'(?:, id \d+)?(?:, line (?P<line>\d+))?\s*$"
)
_BROKEN = re.compile(
    r"XML parse error.*Error=XML_(?:ERROR_)?(?P<what>\w+) .*Line number=(?P<line>\d+)"
)
_PREFIX = re.compile(r"^(?:(?:XML )?Error|ParseXML|FatalError|MuJoCo cannot \w+ it): ")
# What MuJoCo says, and what is said here: what is wrong, and what to do.
_SAID: Sequence[tuple[str, str]] = (
    (
        r"mass and inertia of moving bodies must be larger than.*",
        "body {name} moves and has no mass; give it an <inertial>, or a geom with a mass",
    ),
    (
        r"inertia must satisfy A \+ B >= C.*",
        "the inertia of body {name} is that of nothing: each of its three numbers may be at most "
        'the sum of the others; correct it, or write <compiler balanceinertia="true"/>',
    ),
    (r"plugin (\S+) not found", r"the plugin \1 is not at hand; remove it from the file"),
    (
        r"Error opening file '(.*)'",
        r"the file \1 is missing, or cannot be opened; put it where the file says",
    ),
    (
        r"could not parse model file with error: .*Error opening file '(.*)'.*",
        r"the file \1 is missing, or cannot be opened; put it where the file says",
    ),
    (
        r"unknown default class name '(.*)'",
        r"the class \1 has no <default>; if another file has it, name the file that includes both",
    ),
    (
        r"unknown transmission target '(.*)' for actuator.*",
        r"actuator {name} drives \1, which the file does not have; correct the name, or remove it",
    ),
    (
        r"Lengthrange computation did not converge in actuator (\d+):.*",
        r"MuJoCo finds no range of lengths for the muscle number \1; give it a lengthrange, or "
        "use <motor>",
    ),
    (
        r"Unrecognized XML model type: '(.*)'",
        r"its first element is <\1>; write <mujoco>, or a URDF",
    ),
    (r"empty file.*", "it is empty; name an MJCF or URDF file"),
    (
        r"Schema violation: unrecognized attribute: '(.*)'",
        r"<{tag}> has no attribute \1; correct it",
    ),
    (r"Schema violation: unrecognized element", "<{tag}> has no place there; remove it"),
    (
        r"File '(.*)' already included",
        r"the file \1 is included twice, which MuJoCo cannot; include it once",
    ),
    (
        r"mesh '(.*)' has coplanar vertices.*",
        r"the mesh \1 is flat, and cannot collide; use a thin box, or a plane, in its place",
    ),
    (
        r"\w+_decoder: .*",
        "the file of mesh {name} cannot be read; replace it",
    ),
)


def sentence(message: str, places: Sequence[Place]) -> str:
    """Returns what a message of MuJoCo says, in one line that begins with where it is.

    Args:
      message: MuJoCo's own.
      places: the elements of the file.
    """
    broken = _BROKEN.search(" ".join(message.split()))
    if broken:
        kind = broken["what"].lower().replace("_", " ")
        return f"line {broken['line']}: it is no XML ({kind}); correct it"
    found = _ELEMENT.search(message)
    what = message[: found.start()] if found else message
    what = " ".join(what.split())
    while (shorter := _PREFIX.sub("", what)) != what:
        what = shorter
    name, line = (found["name"], int(found["line"] or 0)) if found else ("", 0)
    parsing = found is not None and "Element name" not in found[0]
    place = _place(places, line, name, what, parsing=parsing)
    where = f"{place}: " if place else f"line {line}: " if line else ""
    tag = name if parsing else place.tag if place else "element"
    for pattern, words in _SAID:
        if match := re.fullmatch(pattern, what):
            shown = (name or "without a name").replace("\\", "\\\\")
            return where + match.expand(words.format(name=shown, tag=tag))
    shown = f" in <{tag}{f' name={name}' * (not parsing and bool(name))}>" if name else ""
    return f"{where}MuJoCo cannot take it: {what.rstrip('.')}{shown}; correct it"


def _place(
    places: Sequence[Place], line: int, name: str, what: str, *, parsing: bool
) -> Place | None:
    """Returns the element that a message is about; None if that is not sure."""
    if parsing:
        return lines.one_of(places, line=line, tags=(name,))
    kinds = [tags for word, tags in lines.TAGS.items() if re.search(rf"\b{word}\b", what)]
    kinds += [(word,) for word in ("geom", "joint", "site", "mesh") if f" {word} " in f" {what} "]
    for tags in (*kinds, ()):
        place = lines.one_of(places, line=line, tags=tags, name=name)
        if place:
            return place
    return None
