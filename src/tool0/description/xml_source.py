"""XML elements with file and line, and typed access to the elements' values.

An element keeps its location when xacro clones a macro's body.  Therefore an error in
expanded XML refers to the source of the macro.  Comments and white space between
elements are omitted, since they are not used and xacro is much faster without them.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import Any, final
from xml.dom import NotFoundErr
from xml.dom.minidom import Attr, Document, Element, Node
from xml.parsers import expat

from tool0.description.transform import Pose, Vector3
from tool0.description.units import within_a_turn
from tool0.errors import DescriptionError, ModelError, SourceLocation, did_you_mean

MAX_DEPTH = 500
"""Largest nesting depth.  The depth is limited, since minidom visits all ancestors of
each new element."""


@final
class LocatedElement(Element):
    """A DOM element with its source location.

    The attributes of the element are a plain dict. minidom would store each attribute
    as a node in two dicts, which would take up a third of the expansion time.
    """

    def __init__(self, tag: str, location: SourceLocation | None = None) -> None:
        super().__init__(tag)
        self.location = location
        self._values: dict[str, str] = {}

    @property
    def attributes(self) -> Any:  # type: ignore[override]  # a NamedNodeMap in minidom
        """Copy of the attributes; xacro calls only its ``items`` and ``keys``."""
        return dict(self._values)

    def hasAttribute(self, name: str) -> bool:
        return name in self._values

    def getAttribute(self, attname: str) -> str:
        return self._values.get(attname, "")

    def setAttribute(self, attname: str, value: str) -> None:
        self._values[attname] = value

    def removeAttribute(self, name: str) -> None:
        if self._values.pop(name, None) is None:
            raise NotFoundErr

    def getAttributeNode(self, attrname: str) -> Any:  # an Attr or None
        if attrname not in self._values:
            return None
        node = Attr(attrname)
        node.value = self._values[attrname]
        return node

    def cloneNode(self, deep: bool) -> LocatedElement:
        """Return a copy with the same source location."""
        clone = LocatedElement(self.tagName, self.location)
        clone.ownerDocument = self.ownerDocument
        clone._values = dict(self._values)
        if deep:
            for child in self.childNodes:
                copy: Any = child.cloneNode(True)
                clone.appendChild(copy)
        return clone

    def writexml(
        self, writer: Any, indent: str = "", addindent: str = "", newl: str = ""
    ) -> None:
        """Write the element and its children; one with only text gets a single line."""
        attributes = "".join(
            f' {name}="{value.translate(_ESCAPES)}"'
            for name, value in self._values.items()
        )
        writer.write(f"{indent}<{self.tagName}{attributes}")
        if not self.childNodes:
            writer.write(f"/>{newl}")
        elif len(self.childNodes) == 1 and not isinstance(self.childNodes[0], Element):
            text = (self.childNodes[0].nodeValue or "").translate(_ESCAPES)
            writer.write(f">{text}</{self.tagName}>{newl}")
        else:
            writer.write(f">{newl}")
            for child in self.childNodes:
                child.writexml(writer, indent + addindent, addindent, newl)
            writer.write(f"{indent}</{self.tagName}>{newl}")


_ESCAPES = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\n": "&#10;"}
)
"""Escape sequences for XML text between tags or in double quotes."""


def parse_file(path: Path) -> Document:
    """Return the XML document in the file ``path``.

    Raises:
        DescriptionError: If the file cannot be read or is not well-formed XML.
    """
    try:
        text = path.read_bytes()
    except OSError as error:
        raise DescriptionError(
            f"cannot read '{path}': {error.strerror}; check the path"
        ) from error
    return parse_text(text, path)


def parse_text(text: str | bytes, file: Path | None = None) -> Document:
    """Return the XML document in ``text``, which was read from ``file``.

    Raises:
        DescriptionError: If the text is not well-formed or declares entities.
    """
    return _Builder(file).build(text)


def locate(node: Node | None) -> SourceLocation | None:
    """Return the source location of ``node``, or of the nearest element around it."""
    while node is not None:
        if isinstance(node, LocatedElement) and node.location is not None:
            return node.location
        node = node.parentNode
    return None


def children(element: Element, tag: str | None = None) -> Iterator[Element]:
    """Yield the child elements of ``element``, or only those called ``tag``."""
    for node in element.childNodes:
        if isinstance(node, Element) and (tag is None or node.tagName == tag):
            yield node


def to_text(document: Document) -> str:
    """Return ``document`` as indented XML, without white space between elements."""
    for element in document.getElementsByTagName("*"):
        for child in list(element.childNodes):
            if not isinstance(child, Element) and not (child.nodeValue or "").strip():
                element.removeChild(child)  # xacro does not remove blank text
    return document.toprettyxml(indent="  ")


@final
class _Builder:
    """Builder of one document from the events of expat."""

    def __init__(self, file: Path | None) -> None:
        self._file = file
        self._document = Document()
        self._around: list[Element] = []  # the elements that are not closed yet
        self._prefixes = {"xml", "xmlns"}
        self._parser = parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.ordered_attributes = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._text
        parser.StartDoctypeDeclHandler = self._doctype

    def build(self, text: str | bytes) -> Document:
        """Return the document in ``text``, or raise DescriptionError."""
        try:
            self._parser.Parse(text, True)
        except expat.ExpatError as error:
            raise DescriptionError(
                f"not well-formed XML: {error}; check the tags around there",
                SourceLocation(self._file, error.lineno),
            ) from error
        return self._document

    def _here(self) -> SourceLocation:
        return SourceLocation(self._file, self._parser.CurrentLineNumber)

    def _start(self, name: str, attributes: list[str]) -> None:
        element = LocatedElement(name, self._here())
        element.ownerDocument = self._document
        for key, value in zip(attributes[::2], attributes[1::2], strict=True):
            element.setAttribute(key, value)
            if key.startswith("xmlns:"):
                self._prefixes.add(key.removeprefix("xmlns:"))
        prefix, colon, _ = name.partition(":")
        if colon and prefix not in self._prefixes:
            meaning = "http://www.ros.org/wiki/xacro" if prefix == "xacro" else prefix
            raise DescriptionError(
                f"<{name}> has an undeclared prefix; declare it in <robot>: "
                f'xmlns:{prefix}="{meaning}"',
                element.location,
            )
        if len(self._around) >= MAX_DEPTH:
            raise DescriptionError(
                f"<{name}> is the {MAX_DEPTH + 1}th element inside one another, and "
                f"{MAX_DEPTH} is the limit; close the elements before it",
                element.location,
            )
        parent = self._around[-1] if self._around else self._document
        parent.appendChild(element)
        self._around.append(element)

    def _end(self, _: str) -> None:
        self._around.pop()

    def _text(self, data: str) -> None:
        if self._around and not data.isspace():
            self._around[-1].appendChild(self._document.createTextNode(data))

    def _doctype(
        self, _name: str, _system: str | None, _public: str | None, declares: bool
    ) -> None:
        """Reject entity declarations, which can expand a small file to gigabytes."""
        if declares:
            raise DescriptionError(
                "declarations in <!DOCTYPE …> are not allowed; remove them, "
                "and write xacro properties instead of entities",
                self._here(),
            )


def required(element: Element, attribute: str) -> str:
    """Return the text of ``attribute``, or raise DescriptionError."""
    if not element.hasAttribute(attribute):
        raise DescriptionError(
            f'<{element.tagName}> lacks the attribute {attribute}="…"', locate(element)
        )
    text = element.getAttribute(attribute).strip()
    if not text:
        raise DescriptionError(
            f'<{element.tagName} {attribute}=""> is empty; give it a value',
            locate(element),
        )
    return text


def only_child(element: Element, tag: str) -> Element | None:
    """Return the only child called ``tag``, or None if there is no such child."""
    found = list(children(element, tag))
    if len(found) > 1:
        raise DescriptionError(
            f"<{element.tagName}> has {len(found)} <{tag}>; leave one", locate(found[1])
        )
    return found[0] if found else None


def required_child(element: Element, tag: str) -> Element:
    """Return the only child called ``tag``, or raise DescriptionError."""
    child = only_child(element, tag)
    if child is None:
        name = element.getAttribute("name")
        of = f" of '{name}'" if name else ""
        raise DescriptionError(
            f"<{element.tagName}>{of} lacks <{tag}>", locate(element)
        )
    return child


def number(element: Element, attribute: str, default: float | None = None) -> float:
    """Return ``attribute`` as a number; it is required if there is no ``default``."""
    (value,) = numbers(element, attribute, 1, None if default is None else [default])
    return value


def numbers(
    element: Element, attribute: str, count: int, default: Sequence[float] | None = None
) -> tuple[float, ...]:
    """Return ``count`` numbers from ``attribute``, separated by spaces."""
    if default is not None and not element.hasAttribute(attribute):
        return tuple(default)
    return to_numbers(required(element, attribute), count, element, attribute)


def to_numbers(text: str, count: int, element: Element, what: str) -> tuple[float, ...]:
    """Return ``count`` finite numbers from ``text``, found in ``element``."""
    words = text.split()
    if len(words) != count:
        raise DescriptionError(
            f"<{element.tagName}>: {what} '{text}' has {len(words)} numbers; "
            f"give {count}, separated by spaces",
            locate(element),
        )
    values = []
    for word in words:
        try:
            values.append(float(word))
        except ValueError:
            values.append(math.nan)
        if not math.isfinite(values[-1]):
            raise DescriptionError(
                f"<{element.tagName}>: {what} '{word}' is not a finite number",
                locate(element),
            )
    return tuple(values)


def vector(
    element: Element, attribute: str, default: Sequence[float] | None = None
) -> Vector3:
    """Return three numbers from ``attribute``."""
    x, y, z = numbers(element, attribute, 3, default)
    return (x, y, z)


def origin(element: Element) -> Pose:
    """Return the ``<origin>`` of ``element``, or the identity if there is no origin."""
    child = only_child(element, "origin")
    if child is None:
        return Pose()
    zero = (0.0, 0.0, 0.0)
    roll, pitch, yaw = map(within_a_turn, vector(child, "rpy", zero))
    return Pose(xyz=vector(child, "xyz", zero), rpy=(roll, pitch, yaw))


def not_negative(value: float, what: str, element: Element) -> float:
    """Return ``value``, or raise ModelError with text ``what`` if ``value`` < 0."""
    if not value >= 0:
        raise ModelError(f"{what} {value:g}; it must not be negative", locate(element))
    return value


def positive(element: Element, attribute: str) -> float:
    """Return ``attribute`` as a number above zero."""
    value = number(element, attribute)
    if not value > 0:
        raise DescriptionError(
            f'<{element.tagName} {attribute}="{value:g}">: must be above zero',
            locate(element),
        )
    return value


def choice(text: str, valid: Sequence[str], element: Element, what: str) -> str:
    """Return ``text`` if it is one of ``valid``, or raise DescriptionError."""
    if text not in valid:
        hint = did_you_mean(text, list(valid))
        raise DescriptionError(f"unknown {what} '{text}'{hint}", locate(element))
    return text


def require_known(
    name: str, valid: Collection[str], what: str, location: SourceLocation | None
) -> None:
    """Raise ModelError with the text ``what`` unless ``name`` is in ``valid``."""
    if name not in valid:
        raise ModelError(f"{what} '{name}'{did_you_mean(name, list(valid))}", location)


def text_of(element: Element) -> str:
    """Return the text inside ``element``, without leading and trailing white space."""
    texts = (node for node in element.childNodes if not isinstance(node, Element))
    return "".join(node.nodeValue or "" for node in texts).strip()


def child_number(element: Element, tag: str) -> float | None:
    """Return the number inside the child ``tag``, or None if there is no such child."""
    child = only_child(element, tag)
    return None if child is None else to_numbers(text_of(child), 1, child, tag)[0]
