"""Linting of YAML for ros2_control: keys that no node reads, and wrong types.

ROS 2 silently ignores an unknown parameter.  A parameter of the wrong type, such as
``1`` where a double is declared, prevents the controller from being loaded. tool0
accepts a parameter of the wrong type and reports it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Final

from tool0.control.controller_lint import (
    ControllerLint,
    limit_findings,
    or_remove,
    severity_of,
)
from tool0.control.dialect import Declared
from tool0.control.ros2.dialect import ROS2
from tool0.control.ros2.layout import (
    MANAGER,
    Node,
    declared_in,
    nodes,
    parameters_in,
    places,
)
from tool0.description.finding import Finding, error_at
from tool0.description.yaml_tree import Tree, YamlEntry
from tool0.errors import is_typo, nearest_name

_SIMILAR: Final = 0.75
_OF_MANAGER: Final = (
    *("update_rate", "use_sim_time", "robot_description", "handle_exceptions"),
    *("enforce_command_limits", "thread_priority", "lock_memory", "cpu_affinity"),
    *("shutdown_on_initial_state_failure", "hardware_components_initial_state"),
    *("defaults", "diagnostics", "overruns", "qos_overrides", "services"),
    *("start_type_description_service", "joint_limits"),
)
"""Parameters of the manager itself; the last parameter is specific to tool0."""


def lint(tree: Tree, joints: Collection[str] | None = None) -> tuple[Finding, ...]:
    """Return findings about unused, ineffective and suspicious parameters.

    ``joints`` are the robot's movable joints; None if they are unknown.
    """
    findings = list(tree.findings)
    for place in places(tree.root):
        controllers = declared_in(tree.root, place)
        manager = parameters_in(tree.root, place, MANAGER)
        if manager is not None:
            findings += _lint_manager(manager, joints)
        for item in controllers.values():
            kind = str(item.type.scalar)
            if kind in ROS2.types:  # loading of other types fails with a reason
                findings += _lint_controller(item.parameters, kind, joints)
    findings += _misnamed(tree.root)
    unique = dict.fromkeys(findings)
    return tuple(
        sorted(unique, key=lambda f: (str(f.location.file), f.location.line or 0))
    )


def _lint_manager(
    manager: YamlEntry, joints: Collection[str] | None
) -> Iterator[Finding]:
    for name, entry in manager.children.items():
        if name == "joint_limits":
            yield from limit_findings(entry, joints)
        elif not entry.is_mapping and name not in _OF_MANAGER:
            near = nearest_name(name, _OF_MANAGER, _SIMILAR)
            if near is not None:
                yield entry.finding(
                    "unread-key",
                    "the controller manager does not read it",
                    or_remove(near),
                    severity_of(name, near),
                )


def _lint_controller(
    parameters: YamlEntry, kind: str, joints: Collection[str] | None
) -> Iterator[Finding]:
    controller = ControllerLint(ROS2, parameters, kind, joints)
    yield from controller.findings()
    declared = ROS2.values_of(kind)
    for leaf in parameters.leaves():
        value = leaf.scalar
        is_integer = isinstance(value, int) and not isinstance(value, bool)
        if is_integer and isinstance(declared.get(controller.pattern_of(leaf)), float):
            yield leaf.finding(
                "wrong-type",
                f"ROS 2 declares a double, and refuses the integer {value}: the "
                "controller does not load",
                f"write {value}.0",
            )


def _misnamed(root: YamlEntry) -> Iterator[Finding]:
    """Yield findings about parameters under a wrong controller name or namespace.

    Only controllers that have no parameters under their exact names are considered.
    """
    everything = [(place, declared_in(root, place)) for place in places(root)]
    known = {name for _, controllers in everything for name in controllers}
    for place, controllers in everything:
        without = [n for n, item in controllers.items() if _is_bare(root, place, n)]
        for node in nodes(root):
            yield from _of_another(node, place, controllers, without, known)


def _is_bare(root: YamlEntry, place: tuple[str, ...] | None, name: str) -> bool:
    """Return whether a YAML tree has no parameters under a controller's exact name."""
    return not any(
        node.path in ((name,), (*(place or ()), name)) for node in nodes(root)
    )


def _of_another(
    node: Node,
    place: tuple[str, ...] | None,
    controllers: Mapping[str, Declared],
    without: Collection[str],
    known: Collection[str],
) -> Iterator[Finding]:
    name = node.path[-1]
    if place is None or not node.is_single or name == MANAGER:
        return
    near = nearest_name(name, without, _SIMILAR)
    if name not in known and near is not None and is_typo(name, near):
        yield error_at(
            node.entry.location,
            "no-controller",
            name,
            "the controller manager declares no such controller, so these parameters "
            "are unused",
            f"did you mean '{near}'?",
        )
    elif name in without and name in controllers:
        there, here = "/".join(("", *node.path[:-1])), "/".join(("", *place))
        yield error_at(
            node.entry.location,
            "no-controller",
            name,
            f"the controller '{name}' is in the namespace '{here}', and these "
            f"parameters are for '{there}', so they are unused",
            "write them into the namespace of the controller_manager",
        )
