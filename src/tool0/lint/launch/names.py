"""How ROS joins and checks the names of its graph."""

from __future__ import annotations

import re

_LEGAL = re.compile(r"[~/A-Za-z][\w/]*", re.ASCII)


def is_legal(name: str) -> bool:
    """Whether ROS accepts ``name`` for a node or a topic."""
    return not name or (bool(_LEGAL.fullmatch(name)) and "//" not in name)


def join(namespace: str, name: str) -> str:
    """Return ``name`` in ``namespace``; a global or private one stays as it is."""
    if not namespace or name.startswith(("/", "~")):
        return name
    return f"{namespace.removesuffix('/')}/{name}"


def canonical(name: str) -> str:
    """Return ``name`` without doubled and trailing slashes."""
    start = "/" if name.startswith("/") else ""
    return start + "/".join(part for part in name.split("/") if part)


def as_namespace(name: str) -> str:
    """Return ``name`` from the root on, with a slash at its end."""
    inside = canonical(name).strip("/")
    return f"/{inside}/" if inside else "/"


def converted(value: str) -> str | float | int | bool:
    """Return what roslaunch makes of a text if no type is given."""
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
    """Return what ``if`` makes of a text; None if that is an error."""
    word = value.lower().strip()
    if word in ("true", "1"):
        return True
    return False if word in ("false", "0") else None
