"""A gamepad or a SpaceMouse as a teleoperator of LeRobot: it moves the robot's tool."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, final

from lerobot.teleoperators.utils import TeleopEvents

from lerobot_robot_tool0.config import (
    Tool0GamepadConfig,
    Tool0SpaceMouseConfig,
    ToolTeleopConfig,
)
from lerobot_robot_tool0.device import Command, Device, Grip
from lerobot_robot_tool0.jogging import ArmJog
from lerobot_robot_tool0.joints import named
from lerobot_robot_tool0.observer import Observer
from tool0.description.grasp_frames import flange_of
from tool0.errors import ControlError


class ToolTeleoperator(Observer):
    """Moves the tool of an arm by a device.

    Joints of another arm stay where they are at the first action.
    """

    config: ToolTeleopConfig

    def __init__(self, config: ToolTeleopConfig) -> None:
        """Note which bring-up it is; it need not run yet."""
        super().__init__(config)
        self._device: Device | None = None
        self._jog: ArmJog | None = None
        self._targets: dict[str, float] = {}
        self._grips: dict[str, dict[Grip, float]] = {}
        """Joint of a gripper → its positions [rad | m], open and closed."""
        self._grip: Grip | None = None
        self._events: set[TeleopEvents] = set()

    @abstractmethod
    def _opened_device(self) -> Device:
        """Return the device, or raise ControlError."""

    @property
    def is_connected(self) -> bool:
        """Whether the device is open."""
        return self._device is not None

    def connect(self, calibrate: bool = True) -> None:
        """Open the device, and connect to the bring-up; nothing moves.

        Raises:
            ControlError: If there is no device, or no such arm.
            TransportError: If the bring-up does not run.
        """
        self._opened()
        assert self._robot is not None
        jog = ArmJog(
            self._robot,
            self.config.arm,
            speed=(self.config.speed, self.config.turn_speed),
            frame=self.config.frame,
        )
        model = self._robot.description.model
        self._grips = {
            item.joint: {
                "open": item.position(item.max_opening),
                "close": item.position(0.0),
            }
            for item in (found.geometry for found in self._robot.grippers.values())
            if flange_of(model, item) == jog.arm.tip
        }
        self._device, self._jog = self._opened_device(), jog

    def get_action(self) -> dict[str, Any]:
        """Return target positions of the driven joints [rad | m].

        While the device is unplugged they stay.

        Raises:
            ControlError: If it is not connected.
            TransportError: If the bring-up has ended.
        """
        command = self._read()
        jog, environment = self._jog, self._environment
        assert jog is not None
        assert environment is not None
        joints = named(environment.action_names, "pos")
        if not self._targets:
            seen = environment.see().values["position"].tolist()
            self._targets = dict(zip(joints, seen, strict=True))
        arm = jog.follow(None if command is None else command.shares)
        moved = dict(zip(jog.arm.joint_names, arm.tolist(), strict=True))
        if jog.is_ready and self._grip is not None:
            moved |= {name: ends[self._grip] for name, ends in self._grips.items()}
        self._grip = None
        self._targets |= {f"{name}.pos": value for name, value in moved.items()}
        return dict(self._targets)

    def get_teleop_events(self) -> dict[TeleopEvents, bool]:
        """Return which ends of the episode were chosen since the last call.

        An intervention is a device that is not neutral.
        """
        command = self._read()
        events, self._events = self._events, set()
        chosen = {event: event in events for event in TeleopEvents}
        moves = command is not None and bool(command.shares.any())
        return {**chosen, TeleopEvents.IS_INTERVENTION: moves}

    def disconnect(self) -> None:
        """Let go of the device, and end the connection."""
        if self._device is not None:
            self._device.close()
        super().disconnect()
        self._device = self._jog = None
        self._targets, self._events = {}, set()

    def _read(self) -> Command | None:
        if self._device is None:
            raise ControlError(f"{self} is not connected; call connect() first")
        command = self._device.read()
        if command is not None:
            self._grip = command.grip or self._grip
            self._events |= command.events
        return command


@final
class Tool0Gamepad(ToolTeleoperator):
    """A gamepad."""

    config_class = Tool0GamepadConfig
    name = "tool0_gamepad"
    config: Tool0GamepadConfig

    def _opened_device(self) -> Device:
        from lerobot_robot_tool0.gamepad import Gamepad  # slow to import

        return Gamepad(self.config.dead_zone, self.config.device)


@final
class Tool0SpaceMouse(ToolTeleoperator):
    """A SpaceMouse."""

    config_class = Tool0SpaceMouseConfig
    name = "tool0_spacemouse"
    config: Tool0SpaceMouseConfig

    def _opened_device(self) -> Device:
        from lerobot_robot_tool0.spacemouse import SpaceMouse

        return SpaceMouse(self.config.dead_zone)
