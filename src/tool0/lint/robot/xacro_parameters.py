"""Parameters of macros that nothing uses, and arguments with two defaults."""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.dom.minidom import Element

from tool0.description.attributes import text_of
from tool0.description.finding import Finding, warning_at
from tool0.description.xml_source import children
from tool0.lint.robot.elements import attribute, descendants, place
from tool0.lint.robot.names import short
from tool0.lint.robot.xacro_macros import macros_of, parameters_of

_WORD = re.compile(r"[^\W\d]\w*")
_OUTER = "^"
"""The default that means: what the calling macro calls so."""


def parameter_findings(root: Element) -> Iterator[Finding]:
    """Yield unused parameters, and arguments that are declared twice."""
    yield from _unused(root)
    yield from _declared_twice(root)


def _unused(root: Element) -> Iterator[Finding]:
    # A macro sees what its caller has, so that a use anywhere in the file counts.
    used = set(_used_words(root))
    for macro in macros_of(root):
        for parameter in parameters_of(macro):
            if parameter.name in used or not parameter.name:
                continue
            name = macro.getAttribute("name")
            yield warning_at(
                place(macro),
                "unused-parameter",
                parameter.name,
                f"macro '{short(name)}' takes '{short(parameter.name)}', which "
                "nothing in this file uses: whatever is given for it does nothing",
                (
                    f'use <xacro:insert_block name="{parameter.name}"/>'
                    if parameter.is_block
                    else f"use it, as ${{{short(parameter.name)}}}"
                )
                + ", or take it out of params",
            )


def _used_words(root: Element) -> Iterator[str]:
    for element in descendants(root):
        if element.tagName == "xacro:insert_block":
            yield attribute(element, "name")
        if element.tagName == "xacro:macro":
            for parameter in parameters_of(element):
                if parameter.default == _OUTER:
                    yield parameter.name
        values = (value for _, value in element.attributes.items())
        for text in (text_of(element), *values):
            if "$" in text:
                yield from _WORD.findall(text)


def _declared_twice(root: Element) -> Iterator[Finding]:
    first: dict[str, Element] = {}
    for element in children(root, "xacro:arg"):
        name, default = attribute(element, "name"), attribute(element, "default")
        earlier = first.setdefault(name, element)
        if earlier is element or attribute(earlier, "default") == default:
            continue
        yield warning_at(
            place(element),
            "duplicate-arg",
            name,
            f"the argument '{short(name)}' is declared again with the default "
            f"'{short(default)}', which does nothing: the first counts, "
            f"'{short(attribute(earlier, 'default'))}' at {place(earlier)}",
            "remove one of the two",
        )
