"""Where the elements of a user's file are written, its included files among them.

MuJoCo gives lines of the file itself alone; an element of an included one has line 0.
"""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple
from xml.parsers import expat

_NAMED = re.compile(r"\b(actuator|body|joint|tendon|geom) ([^\s,;:]+)")
_NO_NUMBER = re.compile(r"(?i)[-+]?(nan|inf|infinity)")
_NAMES = (  # attributes whose value may be such a word
    "name class childclass body joint jointinparent geom site tendon mesh material texture hfield "
    "actuator target refsite cranksite slidersite sidesite model file link prefix key value"
).split()
TAGS: Mapping[str, Sequence[str]] = {  # of what MuJoCo and sentences call otherwise
    "bodies": ("body",),
    "collision": ("pair",),
    "bodypair": ("exclude",),
    "key": ("key",),
    "joint": ("joint", "freejoint"),
    "tendon": ("fixed", "spatial"),
    "actuator": "motor position velocity intvelocity general damper muscle cylinder adhesion "
    "plugin".split(),
}


class Place(NamedTuple):
    """An element of a file.

    Attributes:
      tag: what it is.
      attributes: that it has.
      line: where it begins.
      file: the included file that it is in, as it is named; empty for the file itself.
    """

    tag: str
    attributes: dict[str, str]
    line: int
    file: str

    def __str__(self) -> str:
        return f"line {self.line} of {self.file}" if self.file else f"line {self.line}"


def places(path: Path) -> list[Place]:
    """Returns the elements of a file and of those that it includes, as far as they are XML."""
    found: list[Place] = []
    _scan(path.resolve().parent, path.name, "", found, set())
    return found


def one_of(
    found: Sequence[Place], *, line: int = 0, tags: Sequence[str] = (), name: str = ""
) -> Place | None:
    """Returns the one element that has a line, tag and name; None if it is not one alone.

    Args:
      found: all elements.
      line: of the file itself; 0 where it is not known.
      tags: of which it has one; empty where that is not known.
      name: of the element; empty where it has none or it is not known.
    """
    fits = [
        each
        for each in found
        if (not line or (each.line == line and not each.file))
        and (not tags or each.tag in tags)
        and (not name or each.attributes.get("name") == name)
    ]
    return fits[0] if len(fits) == 1 and (line or tags or name) else None


def check_numbers(found: Sequence[Place]) -> None:
    """Raises ValueError if an attribute holds `nan` or `inf` for a number."""
    for place in found:
        for attribute, value in place.attributes.items():
            words = [word for word in value.split() if _NO_NUMBER.fullmatch(word)]
            if words and attribute.rstrip("12") not in _NAMES:
                raise ValueError(
                    f"{place}: {attribute} of <{place.tag}> holds {words[0]}, which is no number; "
                    "write one, or leave it out"
                )


def located(found: Sequence[Place], sentence: str) -> str:
    """Returns a sentence that begins with the line of the first element that it names."""
    if sentence.startswith("line "):
        return sentence
    for word, name in _NAMED.findall(sentence):
        place = one_of(found, tags=TAGS.get(word, (word,)), name=name)
        if place:
            return f"{place}: {sentence}"
    return sentence


def _scan(folder: Path, name: str, shown: str, found: list[Place], seen: set[str]) -> None:
    if name in seen:  # MuJoCo lets no file be included twice
        return
    seen.add(name)
    parser = expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        found.append(Place(tag, attributes, parser.CurrentLineNumber, shown))
        if tag == "include" and "file" in attributes:
            _scan(folder, attributes["file"], attributes["file"], found, seen)

    parser.StartElementHandler = start
    try:
        parser.Parse((folder / name).read_bytes(), True)
    except (OSError, expat.ExpatError):
        return  # MuJoCo says what is wrong
