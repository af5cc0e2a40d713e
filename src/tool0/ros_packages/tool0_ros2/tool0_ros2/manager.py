"""The services, the parameters and the topic of the controller_manager."""

import os
from collections.abc import Callable, Iterable
from functools import partial
from itertools import chain
from typing import Any, Protocol

from controller_manager_msgs import msg, srv
from lifecycle_msgs.msg import State
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile

from tool0_ros2 import requests
from tool0_ros2.bridge import Context
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.messages import fill
from tool0_ros2.requests import (
    ControllerStatus,
    HardwareComponentState,
    HardwareInterfaceState,
    Request,
)
from tool0_ros2.simulated_node import SimulatedNode

NAME = "controller_manager"
STRICT = 2
"""Value of STRICT in controller_manager_msgs/SwitchController.  0 selects the manager's
default, and any other value selects best effort."""
_BEST_EFFORT_BY_DEFAULT = ("humble", "iron", "jazzy", "kilted")
_STATES = {
    "unknown": State.PRIMARY_STATE_UNKNOWN,
    "unconfigured": State.PRIMARY_STATE_UNCONFIGURED,
    "inactive": State.PRIMARY_STATE_INACTIVE,
    "active": State.PRIMARY_STATE_ACTIVE,
    "finalized": State.PRIMARY_STATE_FINALIZED,
}


def manager_node(context: Context, update_rate: float, urdf: str) -> Any:
    """Return the node ``controller_manager``, including its parameters.

    Other parameters, such as ``<controller>.type``, can be set without being declared.
    """
    names = context.names
    types = context.info["defined_controllers"].items()
    values = {
        "update_rate": round(update_rate),
        "robot_description": urdf,
        **{
            f"{names.to_ros(name)}.type": kind
            for name, kind in types
            if names.owns(name)
        },
    }
    return SimulatedNode(
        NAME,
        root=names.root,
        ros=context.node.context,
        values=values,
        allow_undeclared_parameters=True,
        automatically_declare_parameters_from_overrides=True,
    )


class ControllerManager:
    """Answers requests as ros2_control's controller_manager does."""

    def __init__(self, context: Context, follow: Callable[[], None]) -> None:
        """Offer the services on the context's node, which ``manager_node`` created.

        ``follow`` waits until the controllers in ROS match the controllers in the
        simulation.
        """
        self._context = context
        self._follow = follow
        self._call = context.connection.call
        self._offer("ListControllers", self._list_controllers)
        self._offer("ListControllerTypes", self._list_types)
        self._offer("ListHardwareComponents", self._list_components)
        self._offer("ListHardwareInterfaces", self._list_interfaces)
        self._offer("LoadController", self._changing(self._load))
        for kind, request in (
            ("ConfigureController", requests.configure_controller),
            ("UnloadController", requests.unload_controller),
            ("CleanupController", requests.cleanup_controller),
        ):
            self._offer(kind, self._changing(partial(self._call_by_name, request)))
        self._offer("SwitchController", self._changing(self._switch))
        self._offer("ReloadControllerLibraries", self._changing(self._reload))
        self._offer("SetHardwareComponentState", self._set_component)
        self._activity: Any = None
        activity = getattr(msg, "ControllerManagerActivity", None)
        if activity is not None:  # Humble does not have this message
            latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
            self._activity = context.node.create_publisher(
                activity, "~/activity", latched
            )
        self._last_activity: Any = None

    def publish_activity(self, statuses: list[ControllerStatus]) -> None:
        """Publish the states of the controllers if they have changed."""
        states = [(item["name"], item["state"]) for item in statuses]
        if self._activity is None or states == self._last_activity:
            return
        self._last_activity = states
        own = self._context.names.to_ros
        components = self._context.ask(requests.list_hardware(), "hardware components")
        message = msg.ControllerManagerActivity()
        message.header.stamp = self._context.clock.now()
        message.controllers = [
            msg.NamedLifecycleState(name=own(name), state=_lifecycle(state))
            for name, state in states
        ]
        message.hardware_components = [
            msg.NamedLifecycleState(name=item["name"], state=_lifecycle(item["state"]))
            for item in self._owned(components or [])
        ]
        self._activity.publish(message)

    # ---- services -------------------------------------------------------------------

    def _offer(self, kind: str, handler: Callable[[Any, Any], Any]) -> None:
        service = getattr(srv, kind, None)
        if service is None:
            return  # this distribution does not have this service
        name = "".join(f"_{c.lower()}" if c.isupper() else c for c in kind)[1:]

        def answer(request: Any, response: Any) -> Any:
            try:
                return handler(request, response)
            except Exception as error:  # the client waits for an answer
                is_known = isinstance(error, RequestFailedError)
                text = self._context.names.text(error if is_known else repr(error))
                self._context.report.error(f"{name}: {text}")
                return fill(response, ok=False, message=text)

        qos = QoSProfile(history=HistoryPolicy.KEEP_ALL)
        self._context.node.create_service(service, f"~/{name}", answer, qos_profile=qos)

    def _changing(self, operation: Callable[[Any], Any]) -> Callable[[Any, Any], Any]:
        """Return the handler of a service that changes controllers."""

        def handle(request: Any, response: Any) -> Any:
            operation(request)
            self._follow()
            return fill(response, ok=True)

        return handle

    def _call_by_name(self, request: "_OfController", message: Any) -> None:
        self._call(request(name=self._context.names.to_model(message.name)))

    def _controllers(self) -> list[ControllerStatus]:
        owns = self._context.names.owns
        return [c for c in self._call(requests.list_controllers()) if owns(c["name"])]

    def _components(self) -> list[HardwareComponentState]:
        return self._owned(self._call(requests.list_hardware()))

    def _owned(
        self, components: list[HardwareComponentState]
    ) -> list[HardwareComponentState]:
        owns = self._context.names.owns
        return [item for item in components if owns(item["name"])]

    def _list_controllers(self, request: Any, response: Any) -> Any:
        names, rate = self._context.names, self._update_rate()
        response.controller = [
            fill(
                msg.ControllerState(),
                name=names.to_ros(item["name"]),
                type=item["type"],
                state=item["state"],
                update_rate=rate,
                claimed_interfaces=self._own(
                    item["command_interfaces"] if item["is_running"] else []
                ),
                required_command_interfaces=self._own(item["command_interfaces"]),
                required_state_interfaces=self._own(item["state_interfaces"]),
            )
            for item in self._controllers()
        ]
        return response

    def _own(self, interfaces: list[str]) -> list[str]:
        return list(map(self._context.names.to_ros, interfaces))

    def _update_rate(self) -> int:
        rate: int = self._context.node.get_parameter("update_rate").value
        return rate

    def _list_types(self, request: Any, response: Any) -> Any:
        types = self._call(requests.list_controller_types())
        return fill(
            response,
            types=[item["name"] for item in types],
            base_classes=[item["base"] for item in types],
        )

    def _load(self, request: Any) -> None:
        """Load a controller with the current parameters of this node.

        The spawner expects this behavior.
        """
        node, name = self._context.node, request.name
        params = {
            key: node.get_parameter_or(f"{name}.{key}").value
            for key in ("type", "params_file")
        }
        files = params["params_file"] or []
        self._call(
            requests.load_controller(
                name=self._context.names.to_model(name),
                type=params["type"] or None,
                files=[files] if isinstance(files, str) else list(files),
                configure=False,
            )
        )

    def _switch(self, request: Any) -> None:
        start, stop = (
            list(request.activate_controllers),
            list(request.deactivate_controllers),
        )
        if hasattr(request, "start_controllers"):  # the old names, which Humble uses
            start += request.start_controllers
            stop += request.stop_controllers
        strictness = request.strictness
        if strictness == 0:
            distribution = os.environ.get("ROS_DISTRO", "")
            strict = distribution not in _BEST_EFFORT_BY_DEFAULT
        else:
            strict = strictness == STRICT
        full = self._context.names.to_model
        self._call(
            requests.switch_controllers(
                start=list(map(full, start)),
                stop=list(map(full, stop)),
                strict=strict,
            )
        )

    def _reload(self, request: Any) -> None:
        """Unload all controllers if ``force_kill`` is set.  No libraries are reloaded.

        Without ``force_kill``, the request is refused if a controller is loaded, as in
        ROS.
        """
        controllers = self._controllers()
        loaded = [item["name"] for item in controllers]
        if loaded and not request.force_kill:
            raise RequestFailedError(
                "ControlError",
                "Not reloading controller libraries because there are controllers "
                f"still loaded: {', '.join(loaded)}; unload them or use force_kill",
            )
        running = [item["name"] for item in controllers if item["is_running"]]
        self._call(requests.switch_controllers(stop=running, strict=False))
        for name in loaded:
            self._call(requests.unload_controller(name=name))

    def _list_components(self, request: Any, response: Any) -> Any:
        rate = self._update_rate()
        response.component = [
            fill(
                msg.HardwareComponentState(),
                name=self._context.names.to_ros(item["name"]),
                type=item["type"],
                class_type=item["plugin"],
                plugin_name=item["plugin"],
                rw_rate=rate,
                state=_lifecycle(item["state"]),
                command_interfaces=self._interfaces(item["command_interfaces"]),
                state_interfaces=self._interfaces(item["state_interfaces"]),
            )
            for item in self._components()
        ]
        return response

    def _list_interfaces(self, request: Any, response: Any) -> Any:
        components = self._components()
        commands = (item["command_interfaces"] for item in components)
        states = (item["state_interfaces"] for item in components)
        response.command_interfaces = self._interfaces(_sorted(commands))
        response.state_interfaces = self._interfaces(_sorted(states))
        return response

    def _interfaces(self, entries: list[HardwareInterfaceState]) -> list[Any]:
        own = self._context.names.to_ros
        return [
            fill(
                msg.HardwareInterface(),
                name=own(entry["name"]),
                data_type="double",
                is_available=entry["is_available"],
                is_claimed=entry["is_claimed"],
            )
            for entry in entries
        ]

    def _set_component(self, request: Any, response: Any) -> Any:
        """Return the unchanged state, because simulated hardware has only one state."""
        by_own = {self._context.names.to_ros(c["name"]): c for c in self._components()}
        component = by_own.get(request.name)
        if component is None:
            raise RequestFailedError(
                "ControlError",
                f"there is no hardware component '{request.name}'; valid ones: "
                + ", ".join(by_own),
            )
        wanted, state = request.target_state, _lifecycle(component["state"])
        response.state = state
        response.ok = wanted.label == state.label or wanted.id == state.id
        if not response.ok:
            self._context.report.error(
                f"the simulated hardware '{request.name}' stays {state.label}"
            )
        return response


class _OfController(Protocol):
    """Function that builds a request about one controller."""

    def __call__(self, *, name: str) -> Request[None]: ...


def _sorted(
    groups: Iterable[list[HardwareInterfaceState]],
) -> list[HardwareInterfaceState]:
    return sorted(chain.from_iterable(groups), key=lambda entry: entry["name"])


def _lifecycle(state: str) -> State:
    return State(id=_STATES.get(state, State.PRIMARY_STATE_UNKNOWN), label=state)
