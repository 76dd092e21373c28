"""An HTML page taken apart by the standard library's parser."""

from html.parser import HTMLParser
from typing import NamedTuple

VOID = ("meta", "br", "link", "img", "hr")


class Element(NamedTuple):
    """A tag and its attributes."""

    tag: str
    attributes: dict[str, str]


class Outline(HTMLParser):
    """What a page consists of.

    Attributes:
      elements: in their order.
      unbalanced: tags that were closed without being the last one opened, or never.
      text: all that is to be read.
    """

    def __init__(self, html: str) -> None:
        super().__init__(convert_charrefs=True)
        self.elements: list[Element] = []
        self.text = ""
        self._open: list[str] = []
        self._wrong: list[str] = []
        self.feed(html)
        self.close()
        self.unbalanced = self._wrong + self._open

    def named(self, *tags: str) -> list[Element]:
        """Returns the elements of these tags."""
        return [element for element in self.elements if element.tag in tags]

    def values(self, attribute: str) -> list[str]:
        """Returns what an attribute is, where it is."""
        return [e.attributes[attribute] for e in self.elements if attribute in e.attributes]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append(Element(tag, {name: value or "" for name, value in attrs}))
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append(Element(tag, {name: value or "" for name, value in attrs}))

    def handle_endtag(self, tag: str) -> None:
        if self._open and self._open[-1] == tag:
            self._open.pop()
        else:
            self._wrong.append(tag)

    def handle_data(self, data: str) -> None:
        if not self._open or self._open[-1] != "style":
            self.text += data
