"""The layout of YAML for ROS 2: parameters under ``ros__parameters`` of nodes.

A node's name may contain a namespace, which is written as YAML levels or with slashes.
The name may also contain wildcards: ``*`` stands for one level, and ``**`` stands for
any number of levels.  Later entries override earlier entries.  A dot in a parameter's
name separates levels.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final, NamedTuple

from tool0.control.dialect import Declared
from tool0.description.yaml_tree import YamlEntry
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError

PARAMETERS: Final = "ros__parameters"
MANAGER: Final = "controller_manager"
_WILDCARDS: Final = ("*", "**")


class Node(NamedTuple):
    """The section of a YAML tree for nodes with names that match a pattern."""

    path: tuple[str, ...]
    """Namespace and name of the node; each part may be a wildcard."""
    entry: YamlEntry
    """The entry with the node's name."""
    parameters: YamlEntry

    @property
    def is_single(self) -> bool:
        """Whether the section applies to a single node."""
        return not any(part in _WILDCARDS for part in self.path)


def is_ros2(root: YamlEntry) -> bool:
    """Return whether a YAML tree contains parameters of nodes."""
    return any(nodes(root))


def nodes(root: YamlEntry) -> Iterator[Node]:
    """Yield every section with parameters, in text order."""
    return _nodes(root, ())


def _nodes(entry: YamlEntry, path: tuple[str, ...]) -> Iterator[Node]:
    for name, child in entry.children.items():
        inner = child.children.get(PARAMETERS)
        if inner is not None:
            yield Node((*path, name), child, inner)
        if name != PARAMETERS:
            yield from _nodes(child, (*path, name))


Place = tuple[str, ...] | None
"""A namespace of nodes; None if the YAML does not specify a namespace."""


def places(root: YamlEntry) -> tuple[Place, ...]:
    """Return the namespaces that contain a manager; (None,) if there is no manager."""
    found = [n.path[:-1] for n in nodes(root) if n.path[-1] == MANAGER and n.is_single]
    return tuple(dict.fromkeys(found)) or (None,)


def declared(root: YamlEntry) -> Mapping[str, Declared]:
    """Return the controllers that have a ``type``.

    The manager's parameters or the controller's parameters contain the type.  The type
    in the manager's parameters takes precedence, as it does for the spawner. tool0 uses
    only the first manager.
    """
    return declared_in(root, places(root)[0])


def declared_in(root: YamlEntry, place: Place) -> Mapping[str, Declared]:
    """Return the controllers in a namespace."""
    manager = parameters_in(root, place, MANAGER)
    found = {
        name: entry.children["type"]
        for name, entry in ({} if manager is None else manager.children).items()
        if "type" in entry.children
    }
    for node in nodes(root):
        name, own = node.path[-1], node.parameters.children.get("type")
        is_here = node.is_single and _is_for(node, place, name)
        if own is not None and "/" in str(own.scalar) and is_here:
            found.setdefault(name, own)
    return {
        name: Declared(
            kind,
            parameters_in(root, place, name) or YamlEntry(name, kind.location, {}),
        )
        for name, kind in found.items()
    }


def parameters(root: YamlEntry, name: str) -> YamlEntry | None:
    """Return the parameters of a node in the manager's namespace, or None."""
    return parameters_in(root, places(root)[0], name)


def parameters_in(root: YamlEntry, place: Place, name: str) -> YamlEntry | None:
    """Return the parameters of a node in a namespace, with levels instead of dots.

    Parameters under the node's name without a namespace also apply to the node.
    """
    result: YamlEntry | None = None
    for node in nodes(root):
        if _is_for(node, place, name):
            if result is None:
                result = YamlEntry(name, node.entry.location, {})
            if node.is_single:
                result.location = node.entry.location
            _overlay(result, node.parameters)
    return result


def joint_limits(root: YamlEntry) -> Namespace | None:
    """Return the ``joint_limits`` of the manager."""
    manager = parameters(root, MANAGER)
    return None if manager is None else Namespace(manager).namespace("joint_limits")


def control_period(root: YamlEntry) -> float | None:
    """Return the control period [s], which is 1 / ``update_rate`` of the manager.

    The result is None if the manager has no rate.
    """
    manager = parameters(root, MANAGER)
    entry = None if manager is None else manager.children.get("update_rate")
    if manager is None or entry is None:
        return None
    rate = Namespace(manager).integer("update_rate", 0)
    if rate < 1:
        raise ConfigError(
            f"'{entry.key}' must be a rate above 0 [Hz], got {rate}", entry.location
        )
    return 1.0 / rate


def _is_for(node: Node, place: Place, name: str) -> bool:
    """Return whether a section applies to node ``name`` in the namespace ``place``."""
    if place is None:
        # A file for the spawner may apply to any namespace.
        return node.path[-1] == name or (
            node.path[-1] in _WILDCARDS and not node.is_single
        )
    return node.path == (name,) or _matches(node.path, (*place, name))


def _matches(pattern: Sequence[str], path: Sequence[str]) -> bool:
    if not pattern:
        return not path
    first, rest = pattern[0], pattern[1:]
    if first == "**":
        return any(_matches(rest, path[k:]) for k in range(len(path) + 1))
    return bool(path) and first in ("*", path[0]) and _matches(rest, path[1:])


def _overlay(target: YamlEntry, source: YamlEntry) -> None:
    """Copy the parameters of ``source``; values replace mappings and vice versa."""
    for name, child in source.children.items():
        *outer, last = name.split(".")
        here = target
        for part in outer:
            here = _mapping_in(here, part, child)
        if child.is_mapping:
            _overlay(_mapping_in(here, last, child), child)
        else:
            here.children[last] = _renamed(child, f"{here.key}/{last}")


def _mapping_in(entry: YamlEntry, name: str, source: YamlEntry) -> YamlEntry:
    found = entry.children.get(name)
    if found is None or not found.is_mapping:
        found = YamlEntry(f"{entry.key}/{name}", source.location, {})
        entry.children[name] = found
    return found


def _renamed(entry: YamlEntry, key: str) -> YamlEntry:
    if not entry.is_list:
        return YamlEntry(key, entry.location, entry.value)
    items = [_renamed(item, f"{key}[{k}]") for k, item in enumerate(entry.items)]
    return YamlEntry(key, entry.location, items)
