"""controller_manager's six services."""

from __future__ import annotations

from typing import Any, final

from tool0.api.robot import Robot
from tool0.control.config import ControllerConfig
from tool0.control.manager import ControllerStatus
from tool0.errors import ControlError, Tool0Error
from tool0.interfaces.ros1.controllers import ControllerEdges
from tool0.interfaces.ros1.conversions import Message
from tool0.interfaces.ros1.node import RosNode
from tool0.interfaces.ros1.parameters import controller_yaml

BEST_EFFORT, STRICT = 1, 2
"""Of controller_manager_msgs/SwitchController; anything else counts as the first."""


@final
class ManagerServices:
    """Answers as ros_control's controller_manager does."""

    def __init__(
        self, node: RosNode, robot: Robot, controllers: ControllerEdges
    ) -> None:
        from controller_manager_msgs import (
            msg,
            srv,
        )

        self._node = node
        self._robot = robot
        self._controllers = controllers
        self._msg, self._srv = msg, srv
        for name, answer in (
            ("ListControllers", self._list),
            ("ListControllerTypes", self._list_types),
            ("LoadController", self._load),
            ("UnloadController", self._unload),
            ("SwitchController", self._switch),
            ("ReloadControllerLibraries", self._reload),
        ):
            service = "".join(f"_{c.lower()}" if c.isupper() else c for c in name)
            node.service(
                f"controller_manager/{service[1:]}", getattr(srv, name), answer
            )

    def _list(self, request: Message) -> Message:
        return self._srv.ListControllersResponse(
            controller=[self._state(status) for status in self._robot.controllers()]
        )

    def _state(self, status: ControllerStatus) -> Message:
        return self._msg.ControllerState(
            name=status.name,
            state=status.state,
            type=status.type,
            claimed_resources=[
                self._msg.HardwareInterfaceResources(
                    hardware_interface=interface.replace("/", "::"),
                    resources=sorted(joints),
                )
                for interface, joints in status.claimed
            ],
        )

    def _list_types(self, request: Message) -> Message:
        types = self._robot.controller_types()
        return self._srv.ListControllerTypesResponse(
            types=types,
            base_classes=["controller_interface::ControllerBase"] * len(types),
        )

    def _load(self, request: Message) -> Message:
        """Load by what the parameter server says now, as the spawner expects."""

        def load() -> None:
            text = controller_yaml(self._node, request.name)
            config = None if text is None else ControllerConfig.from_text(text)
            self._robot.load(request.name, config)
            self._controllers.follow()

        return self._srv.LoadControllerResponse(ok=self._done(load, "load"))

    def _unload(self, request: Message) -> Message:
        def unload() -> None:
            self._robot.unload(request.name)
            self._controllers.follow()

        return self._srv.UnloadControllerResponse(ok=self._done(unload, "unload"))

    def _switch(self, request: Message) -> Message:
        def switch() -> None:
            self._robot.switch(
                request.start_controllers,
                request.stop_controllers,
                strict=request.strictness == STRICT,
            )

        return self._srv.SwitchControllerResponse(ok=self._done(switch, "switch"))

    def _reload(self, request: Message) -> Message:
        """Do what a reload amounts to: nothing is loaded from libraries here.

        As in ROS it is refused while controllers are loaded, unless they may be killed.
        """

        def reload() -> None:
            loaded = [status.name for status in self._robot.controllers()]
            if not loaded:
                return
            if not request.force_kill:
                raise ControlError(
                    "Not reloading controller libraries because there are controllers "
                    f"still loaded: {', '.join(loaded)}; unload them or use force_kill"
                )
            self._robot.switch(stop=loaded, strict=False)
            for name in loaded:
                self._robot.unload(name)
            self._controllers.follow()

        return self._srv.ReloadControllerLibrariesResponse(
            ok=self._done(reload, "reload_libraries")
        )

    def _done(self, act: Any, verb: str) -> bool:
        try:
            act()
        except Tool0Error as error:
            self._node.complain(f"{verb}: {error}")
            return False
        return True
