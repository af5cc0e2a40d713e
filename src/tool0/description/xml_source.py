"""XML whose elements know the file and line they were written on.

The location travels as user data of the DOM node and follows it when xacro clones
a macro's body, so that an error in expanded XML points at the macro's source.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, final
from xml.dom.expatbuilder import ExpatBuilderNS
from xml.dom.minidom import Document, Element, Node
from xml.parsers.expat import ExpatError

from tool0.errors import DescriptionError, SourceLocation

_KEY = "tool0.location"


def parse_file(path: Path) -> Document:
    """Return the document in ``path``.

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
    """Return the document in ``text``, which came from ``file``.

    Raises:
        DescriptionError: If it is not well-formed, or declares entities.
    """
    builder = _LocatingBuilder(file)
    try:
        document = builder.parseString(text)
    except ExpatError as error:
        hint = ""
        if "unbound prefix" in str(error):
            hint = '; declare it: <robot xmlns:xacro="http://www.ros.org/wiki/xacro">'
        raise DescriptionError(
            f"not well-formed XML: {error}{hint}", SourceLocation(file, error.lineno)
        ) from error
    except UnicodeError as error:
        raise DescriptionError(
            f"not text in the declared encoding: {error}", SourceLocation(file)
        ) from error
    return document


def locate(node: Node | None) -> SourceLocation | None:
    """Return where ``node``, or the nearest element around it, was written."""
    while node is not None:
        location = node.getUserData(_KEY) if isinstance(node, Element) else None
        if isinstance(location, SourceLocation):
            return location
        node = node.parentNode
    return None


def children(element: Element, tag: str | None = None) -> Iterator[Element]:
    """Yield the child elements of ``element``, or only those called ``tag``."""
    for node in element.childNodes:
        if isinstance(node, Element) and (tag is None or node.tagName == tag):
            yield node


def to_text(document: Document) -> str:
    """Return ``document`` as indented XML, without comments and blank lines.

    ``document`` itself loses them too.
    """
    _strip(document)
    return document.toprettyxml(indent="  ")


def _strip(node: Node) -> None:
    for child in list(node.childNodes):
        blank = child.nodeType == Node.TEXT_NODE and not child.nodeValue.strip()
        if blank or child.nodeType == Node.COMMENT_NODE:
            node.removeChild(child)
        else:
            _strip(child)


@final
class _CopyOnClone:
    """The handler that lets the location follow a cloned node."""

    def handle(
        self,
        operation: int,
        key: str,
        data: Any,  # the DOM gives user data no type
        source: Node,
        target: Node,
    ) -> None:
        target.setUserData(key, data, self)


_COPY_ON_CLONE: Any = _CopyOnClone()  # the stubs of the DOM know no handler type


@final
class _LocatingBuilder(ExpatBuilderNS):
    """The builder of minidom, which also notes where each element starts.

    A document type with declarations is refused: URDF needs none, and nested
    entities can grow a small file to gigabytes.
    """

    def __init__(self, file: Path | None) -> None:
        super().__init__()
        self._file = file

    def start_element_handler(self, name: str, attributes: list[str]) -> None:
        super().start_element_handler(name, attributes)
        location = SourceLocation(self._file, self.getParser().CurrentLineNumber)
        self.curNode.setUserData(_KEY, location, _COPY_ON_CLONE)

    def start_doctype_decl_handler(
        self,
        doctypeName: str,
        systemId: str | None,
        publicId: str | None,
        has_internal_subset: bool,
    ) -> None:
        if has_internal_subset:
            location = SourceLocation(self._file, self.getParser().CurrentLineNumber)
            raise DescriptionError(
                "declarations in <!DOCTYPE …> are refused; remove them, "
                "and write xacro properties instead of entities",
                location,
            )
        super().start_doctype_decl_handler(
            doctypeName, systemId, publicId, has_internal_subset
        )
