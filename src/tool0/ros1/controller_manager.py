"""The six services of controller_manager, and the topics of loaded controllers."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable
from typing import Any, final

import yaml
from controller_manager_msgs import msg, srv

from tool0.api.robot import Robot
from tool0.control.config import ControllerConfig
from tool0.control.controller import ControllerSpec
from tool0.control.forward_command import ForwardCommandSpec
from tool0.control.gripper_action import GripperActionSpec
from tool0.control.ros1.joint_state import JointStateSpec
from tool0.control.ros1.joint_trajectory import JointTrajectorySpec
from tool0.errors import ControlError, RosUnavailableError, Tool0Error
from tool0.protocol.controllers import ControllerStatus
from tool0.protocol.state import Snapshot
from tool0.ros1.controllers import (
    ForwardCommandBridge,
    GripperActionBridge,
    JointStatePublisher,
    JointTrajectoryBridge,
)
from tool0.ros1.messages import Message
from tool0.ros1.namespace import RosNamespace
from tool0.ros1.node import SnapshotPublisher, WorkerThread

STRICT = 2
"""Value of STRICT in controller_manager_msgs/SwitchController.  Any other value selects
best effort."""
_CLOSE_TIMEOUT = 10.0
"""Time limit for registering one controller's topics with a busy master [wall s].  A
dead master refuses the registration immediately."""
_BRIDGES: dict[type, Callable[..., SnapshotPublisher]] = {
    JointStateSpec: JointStatePublisher,
    JointTrajectorySpec: JointTrajectoryBridge,
    GripperActionSpec: GripperActionBridge,
    ForwardCommandSpec: ForwardCommandBridge,
}
"""ROS interface of a controller, by the class of the controller's parameters."""
_READ_ONLY = (("hardware_interface/JointStateInterface", ()),)
"""Claims that ros_control reports for a controller that claims no resources."""


@final
class ControllerManagerBridge:
    """Acts like ros_control's controller_manager, and presents the loaded controllers.

    The manager and the controllers are in one namespace, and their names are relative
    to this namespace.  The bridge follows every change that is made in ROS, in the
    panel or on the command line.  As in ROS, a controller has topics while it is
    loaded.
    """

    def __init__(self, ros: RosNamespace, robot: Robot) -> None:
        self._ros = ros
        self._robot = robot
        self._bridges: dict[str, tuple[ControllerSpec, SnapshotPublisher]] = {}
        self._loaded: tuple[str, ...] = ()
        self._lock = threading.Lock()
        self._is_closing = False
        # A registration waits for the master, and the publishing thread must not wait.
        self._registrar = WorkerThread("tool0 ros1 registrar")
        self._update()
        self._offer("ListControllers", self._list)
        self._offer("ListControllerTypes", self._list_types)
        self._offer_operation("LoadController", self._load)
        self._offer_operation("UnloadController", self._unload)
        self._offer_operation("SwitchController", self._switch)
        self._offer_operation("ReloadControllerLibraries", self._reload)

    def publish(self, snapshot: Snapshot) -> None:
        """Publish topics of running controllers, and detect loading and unloading."""
        names = (status.name for status in snapshot.controllers)
        loaded = tuple(filter(self._ros.owns, names))
        if loaded != self._loaded:
            self._loaded = loaded
            self._registrar.submit(self._update)
        bridges = self._bridges  # _update() may replace self._bridges in the meantime
        for status in snapshot.controllers:
            if status.is_running and status.name in bridges:
                bridges[status.name][1].publish(snapshot)

    def close(self) -> None:
        """Stop following the controllers.

        The node unregisters all topics and services.

        This method waits for a registration in progress, because the registration would
        otherwise continue after the node has ended.
        """
        self._is_closing = True
        self._registrar.close(_CLOSE_TIMEOUT)

    def _update(self) -> None:
        """Create bridges for new controllers, and close unneeded bridges."""
        with self._lock:
            loaded = {}
            for status in self._controllers():
                try:
                    controller = self._robot.controller(status.name)
                    loaded[status.name] = controller, controller.spec
                except ControlError:
                    continue  # the controller has just been unloaded
            bridges, closed = {}, []
            for name, (spec, bridge) in self._bridges.items():
                if name in loaded and loaded[name][1] is spec:
                    bridges[name] = spec, bridge
                else:
                    closed.append(bridge)
            # publish() must receive the new bridges before an old one is closed
            self._bridges = dict(bridges)
            for bridge in closed:
                bridge.close()
            for name, (controller, spec) in loaded.items():
                # tool0's own controllers have no topics
                kind = _BRIDGES.get(type(spec))
                if name not in bridges and not self._is_closing and kind is not None:
                    bridge = kind(self._ros, spec, controller)
                    bridges[name] = spec, bridge
            self._bridges = bridges

    def _controllers(self) -> list[ControllerStatus]:
        """Return the loaded controllers in the namespace."""
        loaded = self._robot.controllers()
        return [status for status in loaded if self._ros.owns(status.name)]

    def _offer(self, kind: str, handler: Callable[[Message], Message]) -> None:
        name = re.sub("(?<=[a-z])(?=[A-Z])", "_", kind).lower()
        self._ros.service(f"controller_manager/{name}", getattr(srv, kind), handler)

    def _offer_operation(self, kind: str, operation: Callable[[Message], None]) -> None:
        """Offer a service that reports whether the operation succeeded."""

        def handle(request: Message) -> Message:
            response: Any = getattr(srv, f"{kind}Response")()
            try:
                operation(request)
                response.ok = True
            except Tool0Error as error:
                self._ros.log_error(kind, error)
            return response

        self._offer(kind, handle)

    def _list(self, request: Message) -> Message:
        return srv.ListControllersResponse(list(map(self._state, self._controllers())))

    def _list_types(self, request: Message) -> Message:
        types = self._robot.controller_types()
        return srv.ListControllerTypesResponse(
            types=types,
            base_classes=["controller_interface::ControllerBase"] * len(types),
        )

    def _load(self, request: Message) -> None:
        """Load a controller with the current values on the parameter server.

        The spawner expects this behavior.
        """
        name = self._ros.to_model(request.name)
        text = self._controller_yaml(request.name)
        config = None if text is None else ControllerConfig.from_text(text)
        self._robot.load(name, config)
        self._update()

    def _unload(self, request: Message) -> None:
        self._robot.unload(self._ros.to_model(request.name))
        self._update()

    def _switch(self, request: Message) -> None:
        self._robot.switch(
            [self._ros.to_model(name) for name in request.start_controllers],
            [self._ros.to_model(name) for name in request.stop_controllers],
            strict=request.strictness == STRICT,
        )

    def _reload(self, request: Message) -> None:
        """Unload all controllers if ``force_kill`` is set.  No libraries are reloaded.

        Without ``force_kill``, the request is refused if a controller is loaded, as in
        ROS.
        """
        loaded = [status.name for status in self._controllers()]
        if loaded and not request.force_kill:
            raise ControlError(
                "Not reloading controller libraries because there are controllers "
                f"still loaded: {', '.join(loaded)}; unload them or use force_kill"
            )
        self._robot.switch(stop=loaded, strict=False)
        for name in loaded:
            self._robot.unload(name)
        self._update()

    def _state(self, status: ControllerStatus) -> Message:
        own = self._ros.to_ros
        return msg.ControllerState(
            name=own(status.name),
            state=status.state,
            type=status.type,
            claimed_resources=[
                msg.HardwareInterfaceResources(
                    hardware_interface=interface.replace("/", "::"),
                    resources=sorted(map(own, joints)),
                )
                for interface, joints in status.claimed or _READ_ONLY
            ],
        )

    def _controller_yaml(self, own: str) -> str | None:
        """Return a controller's parameters in ROS as YAML; None if there are none."""
        ros = self._ros
        try:
            value: Any = ros.node.master.call("getParam", ros.name(own))
        except RosUnavailableError:
            return None
        if not isinstance(value, dict) or "type" not in value:
            return None
        named = {ros.to_model(own.strip("/")): ros.full_parameters(value)}
        return yaml.safe_dump(named, sort_keys=False)
