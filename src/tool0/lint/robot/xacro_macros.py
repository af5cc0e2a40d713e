"""The macros of a xacro file as it is written, and their parameters."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final
from xml.dom.minidom import Element

from tool0.description.xml_source import children
from tool0.lint.robot.elements import descendants

# As xacro reads them: a name, perhaps := or = and a value, which may be quoted.
_PARAMETER = re.compile(
    r"\s*([^\s:=]+?)(?:\s*(?::=|=)\s*(\^\|)?(?:'([^']*)'|\"([^\"]*)\"|(\S*)))?(?:\s+|$)"
)


@final
@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of a macro: ``name`` or ``name:=default``."""

    name: str
    """Without the stars of a block."""
    default: str | None
    is_block: bool


def macros_of(root: Element) -> Iterator[Element]:
    """Yield the <xacro:macro> elements, those inside others too."""
    for element in descendants(root):
        if element.tagName == "xacro:macro":
            yield element


def own_elements(macro: Element) -> Iterator[Element]:
    """Yield what is in ``macro``, without macros inside that take the same names."""
    names = {parameter.name for parameter in parameters_of(macro)}
    waiting = [macro]
    while waiting:
        element = waiting.pop()
        if element is not macro:
            if element.tagName == "xacro:macro" and names & {
                parameter.name for parameter in parameters_of(element)
            }:
                continue
            yield element
        waiting.extend(reversed(list(children(element))))


def parameters_of(macro: Element) -> tuple[Parameter, ...]:
    """Return the parameters of ``macro``; what makes no sense is left out."""
    text = macro.getAttribute("params")
    found = []
    at = 0
    while at < len(text):
        match = _PARAMETER.match(text, at)
        if match is None or match.end() == at:
            break
        at = match.end()
        name, _, *values = match.groups()
        default = next((value for value in values if value is not None), None)
        found.append(Parameter(name.lstrip("*"), default, name.startswith("*")))
    return tuple(found)
