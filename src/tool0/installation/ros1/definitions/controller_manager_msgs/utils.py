"""Finds controllers and controller managers, as ros_control's module ``utils`` does.

rqt_joint_trajectory_controller and rqt_controller_manager import this module.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import rosgraph
import rospy
import rosservice
from controller_manager_msgs import srv

ControllerState = Any
"""A message of type controller_manager_msgs/ControllerState.  The classes of genpy have
no type annotations."""

_SERVICES = {
    "list_controllers": "ListControllers",
    "list_controller_types": "ListControllerTypes",
    "load_controller": "LoadController",
    "unload_controller": "UnloadController",
    "switch_controller": "SwitchController",
    "reload_controller_libraries": "ReloadControllerLibraries",
}


def get_controller_managers(
    namespace: str = "/", initial_guess: Sequence[str] | None = None
) -> list[str]:
    """Return the sorted namespaces of controller managers below ``namespace``.

    For a namespace in ``initial_guess``, only the service that lists controllers is
    checked.
    """
    suffix = "/list_controllers"
    try:
        services = rosservice.get_service_list(namespace=namespace)
    except rosservice.ROSServiceIOException:
        return []
    listed = {s[: -len(suffix)] or "/" for s in services if s.endswith(suffix)}
    known = set(initial_guess or ())
    return sorted(ns for ns in listed if ns in known or is_controller_manager(ns))


def is_controller_manager(namespace: str) -> bool:
    """Return whether a namespace has all services of a controller manager."""
    return all(
        rosservice.get_service_type(rosgraph.names.ns_join(namespace, name))
        == f"controller_manager_msgs/{kind}"
        for name, kind in _SERVICES.items()
    )


class ControllerManagerLister:
    """Function object that returns the controller managers that are running."""

    def __init__(self, namespace: str = "/") -> None:
        self._namespace = namespace
        self._found: list[str] = []

    def __call__(self) -> list[str]:
        """Return the namespaces of the controller managers, sorted."""
        self._found = get_controller_managers(self._namespace, self._found)
        return self._found


class ControllerLister:
    """Function object that returns the loaded controllers of one controller manager."""

    def __init__(self, namespace: str = "/controller_manager") -> None:
        self._name = rosgraph.names.ns_join(namespace, "list_controllers")
        self._service: Any = None

    def __call__(self) -> list[ControllerState]:
        """Return the controllers, or an empty list if the manager does not answer."""
        for _ in range(2):  # the connection is broken if the manager was restarted
            if self._service is None:
                self._service = rospy.ServiceProxy(
                    self._name, srv.ListControllers, persistent=True
                )
            try:
                return list(self._service().controller)
            except (rospy.ServiceException, rospy.ROSException, OSError):
                self._service.close()
                self._service = None
        return []


def filter_by_name(
    ctrl_list: Iterable[ControllerState], ctrl_name: str, match_substring: bool = False
) -> list[ControllerState]:
    """Return the controllers whose name matches ``ctrl_name``."""
    fits = _matcher(ctrl_name, match_substring)
    return [one for one in ctrl_list if fits(one.name)]


def filter_by_type(
    ctrl_list: Iterable[ControllerState], ctrl_type: str, match_substring: bool = False
) -> list[ControllerState]:
    """Return the controllers whose type matches ``ctrl_type``."""
    fits = _matcher(ctrl_type, match_substring)
    return [one for one in ctrl_list if fits(one.type)]


def filter_by_state(
    ctrl_list: Iterable[ControllerState], ctrl_state: str, match_substring: bool = False
) -> list[ControllerState]:
    """Return the controllers whose state matches ``ctrl_state``."""
    fits = _matcher(ctrl_state, match_substring)
    return [one for one in ctrl_list if fits(one.state)]


def filter_by_hardware_interface(
    ctrl_list: Iterable[ControllerState],
    hardware_interface: str,
    match_substring: bool = False,
) -> list[ControllerState]:
    """Return the controllers that use a matching hardware interface."""
    fits = _matcher(hardware_interface, match_substring)
    return [
        one
        for one in ctrl_list
        if any(fits(claim.hardware_interface) for claim in one.claimed_resources)
    ]


def filter_by_resources(
    ctrl_list: Iterable[ControllerState],
    resources: Iterable[str],
    hardware_interface: str | None = None,
    match_any: bool = False,
) -> list[ControllerState]:
    """Return the controllers that claim the resources through one interface.

    With ``match_any``, a controller that claims any of the resources is included.
    """
    wanted = set(resources)

    def fits(claim: Any) -> bool:
        if hardware_interface not in (None, claim.hardware_interface):
            return False
        claimed = wanted.intersection(claim.resources)
        return bool(claimed) if match_any else claimed == wanted

    return [one for one in ctrl_list if any(map(fits, one.claimed_resources))]


def get_rosparam_controller_names(namespace: str = "/") -> list[str]:
    """Return the names in a namespace that have the parameters of a controller."""
    try:
        parameters = rosgraph.Master(rospy.get_name()).getParam(namespace)
    except rosgraph.MasterError:  # the namespace contains no parameters
        return []
    if not isinstance(parameters, dict):
        return []
    return sorted(
        name
        for name, value in parameters.items()
        if isinstance(value, dict) and not isinstance(value.get("type", {}), dict)
    )


def _matcher(wanted: str, match_substring: bool) -> Callable[[str], bool]:
    if match_substring:
        return lambda text: wanted in text
    return lambda text: text == wanted
