"""The loaded controllers.  Each controller has a part, and a node for parameters."""

import threading
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any

from tool0_ros2 import requests
from tool0_ros2.bridge import Context, ControllerContext, Part, Reporter, Update
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.parameters import ControllerParameters
from tool0_ros2.quiet import only_log_lines
from tool0_ros2.registry import CONTROLLERS, part_class
from tool0_ros2.requests import ControllerStatus
from tool0_ros2.simulated_node import USE_SIM_TIME, SimulatedNode

UNCONFIGURED = "unconfigured"
_BROADCASTER = "JointStateBroadcaster"


@dataclass
class _Loaded:
    """A loaded controller in ROS."""

    type: str
    node: Any
    parameters: dict[str, Any]
    part: Part | None = None
    """The controller's part; None until the controller is configured."""


class Controllers:
    """Follows the loaded controllers in a namespace, whichever client loads them.

    As in ROS, a controller has a node while it is loaded, and topics while it is
    configured.
    """

    def __init__(self, context: Context, executor: Any) -> None:
        self._context = context
        self.names = context.names
        self._executor = executor
        self._loaded: dict[str, _Loaded] = {}
        self._active: tuple[Part, ...] = ()
        self._lock = threading.Lock()

    @property
    def loaded(self) -> Collection[str]:
        """The full names of the loaded controllers."""
        return self._loaded

    @property
    def parts(self) -> list[Part]:
        """The parts of all configured controllers."""
        with self._lock:
            return [item.part for item in self._loaded.values() if item.part]

    def publish(self, update: Update) -> None:
        """Publish the topics of active controllers.

        Call this method in the reader's thread.
        """
        for part in self._active:
            try:
                part.publish(update)
            except Exception as error:  # an error must not stop the other controllers
                self._context.report.error(f"{type(part).__name__}: {error!r}")

    def update(self) -> list[ControllerStatus]:
        """Follow changes in the simulation, and return the status of controllers.

        Call this method in the executor's thread.  The result contains the status of
        each controller in the namespace.
        """
        context = self._context
        statuses = [
            status
            for status in context.ask(requests.list_controllers(), "controllers") or []
            if context.names.owns(status["name"])
        ]
        by_name = {status["name"]: status for status in statuses}
        for name, item in list(self._loaded.items()):
            status = by_name.get(name)
            if status is None or status["type"] != item.type:
                self._close(name)
            elif status["state"] == UNCONFIGURED and item.part is not None:
                self._close_part(item)
        with only_log_lines():
            for status in statuses:
                try:
                    self._follow(status)
                except (RequestFailedError, ImportError) as error:
                    context.report.error(f"{status['name']}: {error}")
        active = (
            item.part
            for name, item in self._loaded.items()
            if item.part is not None and by_name[name]["is_running"]
        )
        self._active = tuple(active)
        context.refresh()
        return statuses

    def has_active_broadcaster(self, statuses: list[ControllerStatus]) -> bool:
        """Return whether an active broadcaster publishes joint states."""
        return any(
            status["is_running"] and status["type"].endswith(_BROADCASTER)
            for status in statuses
        )

    def close(self) -> None:
        """Close all parts and nodes."""
        for name in list(self._loaded):
            self._close(name)

    def _follow(self, status: ControllerStatus) -> None:
        """Create a controller's node and part if they are needed."""
        name, context = status["name"], self._context
        item = self._loaded.get(name)
        if item is None:
            item = _Loaded(status["type"], *self._new_node(name))
            with self._lock:
                self._loaded[name] = item
        if status["state"] == UNCONFIGURED or item.part is not None:
            return
        entry = CONTROLLERS.get(status["type"])
        if entry is None:
            return  # this controller has no ROS interface
        item.parameters.update(self._read(name)[0])
        shared = vars(replace(context, node=item.node))
        part = part_class(entry)(
            ControllerContext(
                **{**shared, "report": Reporter(item.node.get_logger())},
                name=name,
                type=status["type"],
                parameters=item.parameters,
                status=status,
            )
        )
        with self._lock:
            item.part = part

    def _new_node(self, name: str) -> tuple[Any, dict[str, Any]]:
        context, (values, adjustable) = self._context, self._read(name)
        given = values.get(USE_SIM_TIME)
        node = SimulatedNode(
            context.names.to_ros(name),
            root=context.names.root,
            ros=context.node.context,
            values={} if given is None else {USE_SIM_TIME: given},
        )
        ControllerParameters(context, name, node, values, adjustable)
        self._executor.add_node(node)
        return node, values

    def _read(self, name: str) -> tuple[dict[str, Any], set[str]]:
        """Return a controller's parameters, and the names of adjustable parameters."""
        request = requests.read_controller_parameters(controller=name)
        found = self._context.ask(request, "the parameters of controllers") or {}
        values = {key: item["value"] for key, item in found.items()}
        return values, {key for key, item in found.items() if item["is_adjustable"]}

    def _close(self, name: str) -> None:
        with self._lock:
            item = self._loaded.pop(name)
        self._close_part(item)
        self._executor.remove_node(item.node)
        item.node.destroy_node()

    def _close_part(self, item: _Loaded) -> None:
        with self._lock:
            part, item.part = item.part, None
        if part is not None:
            self._active = tuple(p for p in self._active if p is not part)
            part.close()
