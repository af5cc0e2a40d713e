"""Prefixes that a macro takes and does not hand on."""

from __future__ import annotations

from collections.abc import Iterator
from xml.dom.minidom import Element

from tool0.description.finding import Finding, error_at
from tool0.lint.robot.elements import place
from tool0.lint.robot.names import short
from tool0.lint.robot.xacro_macros import macros_of, own_elements, parameters_of

_PREFIX = "prefix"


def call_findings(root: Element) -> Iterator[Finding]:
    """Yield the calls in macros with a prefix that hand on an empty one."""
    for macro in macros_of(root):
        prefixes = {
            parameter.name
            for parameter in parameters_of(macro)
            if parameter.name.endswith(_PREFIX)
        }
        if not prefixes:
            continue
        for call in own_elements(macro):
            for prefix in sorted(prefixes):
                if call.tagName.startswith("xacro:") and _is_empty(call, prefix):
                    yield _hard_coded(macro, call, prefix)


def _is_empty(call: Element, prefix: str) -> bool:
    return call.hasAttribute(prefix) and call.getAttribute(prefix).strip() in {
        "",
        "''",
        "${''}",
        '${""}',
    }


def _hard_coded(macro: Element, call: Element, prefix: str) -> Finding:
    outer, inner = macro.getAttribute("name"), call.tagName
    return error_at(
        place(call),
        "hardcoded-prefix",
        outer,
        f"macro '{short(outer)}' takes a {prefix}, yet hands an empty one to "
        f"<{short(inner)}>: what that makes never has a prefix, so a second one "
        "in the same robot collides, and so does a base_link of both",
        f'write <{short(inner)} {prefix}="${{{prefix}}}" …>',
    )
