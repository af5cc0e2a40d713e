"""The grammar of roslaunch: its elements, attributes, names and values.

The source is https://wiki.ros.org/roslaunch/XML.  ``if`` and ``unless`` are allowed on
every element.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from tool0.description.finding import Finding, error_at, warning_at
from tool0.errors import did_you_mean, nearest_name
from tool0.lint.robot.elements import Tag

_NODE: Final = (
    "pkg type name args machine output respawn respawn_delay required ns clear_params"
    " cwd launch-prefix"
)
ATTRIBUTES: Final[dict[str, frozenset[str]]] = {
    name: frozenset(attributes.split()) | {"if", "unless"}
    for name, attributes in {
        "launch": "deprecated",
        "arg": "name default value doc",
        "include": "file ns clear_params pass_all_args",
        "group": "ns clear_params",
        "param": "name value type textfile binfile command",
        "rosparam": "command file param ns subst_value",
        "node": _NODE,
        "test": f"{_NODE} test-name time-limit retry",
        "remap": "from to",
        "env": "name value",
        "machine": "name address env-loader ssh-port user password default timeout",
        "master": "auto type uri",
    }.items()
}
REQUIRED: Final[dict[str, tuple[str, ...]]] = {
    "arg": ("name",),
    "include": ("file",),
    "param": ("name",),
    "node": ("pkg", "type", "name"),
    "test": ("pkg", "type", "test-name"),
    "remap": ("from", "to"),
    "env": ("name", "value"),
    "machine": ("name", "address"),
}
_ANYTHING: Final = frozenset(ATTRIBUTES) - {"launch"}
_OF_NODES: Final = frozenset({"param", "rosparam", "remap", "env"})
CHILDREN: Final[dict[str, frozenset[str]]] = {
    "launch": _ANYTHING,
    "group": _ANYTHING,
    "include": frozenset({"arg", "env"}),
    "node": _OF_NODES,
    "test": _OF_NODES,
}
"""Allowed children of each element.  An element that is not listed has no children."""

_OBSOLETE: Final[dict[tuple[str, str], str]] = {
    ("machine", name): "was removed in ROS Fuerte; write env-loader instead"
    for name in ("ros-root", "ros-package-path", "ros-ip", "ros-hostname")
}

_LEGAL: Final = re.compile(r"[~/A-Za-z][\w/]*", re.ASCII)
"""Pattern of a name in the ROS graph."""


def findings(tag: Tag) -> Iterator[Finding]:
    """Yield the unknown attributes and the missing attributes of a known element."""
    name = tag.tag
    known, allowed = ATTRIBUTES[name], CHILDREN.get(name, frozenset())
    for key, _ in tag.attributes:
        if key in known or key.startswith("xmlns"):
            continue
        obsolete = _OBSOLETE.get((name, key))
        is_typo = nearest_name(key, known) is not None
        finding_at = error_at if is_typo or obsolete else warning_at
        yield finding_at(
            tag.location,
            "unknown-attribute",
            key,
            obsolete
            or f"is no attribute of <{name}>, and roslaunch ignores it"
            + did_you_mean(key, known),
            f"remove {key}, or write the attribute that was meant",
        )
    for key in REQUIRED.get(name, ()):
        if key not in tag:
            message = f"is missing from <{name}>, and roslaunch stops without it"
            remedy = f'write {key}="…"'
            yield error_at(tag.location, "missing-attribute", key, message, remedy)
    for child in tag.children():
        if child.tag not in allowed:
            hint = did_you_mean(child.tag, allowed) if allowed else ""
            yield warning_at(
                child.location,
                "unknown-element",
                child.tag,
                f"is not allowed in <{name}>, and roslaunch ignores it{hint}",
                f"remove <{child.tag}>, or write the element that was meant",
            )


def is_legal(name: str) -> bool:
    """Return whether ROS accepts ``name`` for a node or a topic."""
    return not name or (bool(_LEGAL.fullmatch(name)) and "//" not in name)


def join(namespace: str, name: str) -> str:
    """Return ``name`` in ``namespace``.  Global and private names do not change."""
    if not namespace or name.startswith(("/", "~")):
        return name
    return f"{namespace.removesuffix('/')}/{name}"


def canonical(name: str) -> str:
    """Return ``name`` without double slashes and without trailing slashes."""
    start = "/" if name.startswith("/") else ""
    return start + "/".join(part for part in name.split("/") if part)


def as_namespace(name: str) -> str:
    """Return ``name`` as a global name that ends with a slash."""
    inside = canonical(name).strip("/")
    return f"/{inside}/" if inside else "/"


def converted(value: str) -> str | float | int | bool:
    """Return the value that roslaunch assigns to a text if no type is given."""
    try:
        if "." in value:
            return float(value)
        if "_" not in value:
            return int(value)
    except ValueError:
        pass
    lowered = value.lower()
    return lowered == "true" if lowered in ("true", "false") else value


def as_boolean(value: str) -> bool | None:
    """Return the value of a text in ``if``; None if roslaunch rejects the text."""
    word = value.lower().strip()
    if word in ("true", "1"):
        return True
    return False if word in ("false", "0") else None
