"""A bring-up of tool0 as a robot of LeRobot."""

from __future__ import annotations

from typing import Any

import numpy as np
from lerobot.robots import Robot

import tool0
from lerobot_robot_tool0.config import Tool0RobotConfig
from lerobot_robot_tool0.joints import named, values_of
from tool0.errors import ControlError
from tool0.policy import RobotEnvironment


class Tool0Robot(Robot):  # type: ignore[misc]  # LeRobot may not be installed
    """Observes joints and cameras; an action is the position of each driven joint.

    Targets that are too far away are approached at the largest speed, as LeRobot's
    ``max_relative_target`` has it.  After a stop the robot does not move again until
    ``connect``.
    """

    config_class = Tool0RobotConfig
    name = "tool0"

    def __init__(self, config: Tool0RobotConfig) -> None:
        """Note which bring-up it is; it need not run yet."""
        super().__init__(config)
        self.config = config
        self._robot: tool0.Robot | None = None
        self._environment: RobotEnvironment | None = None
        self._has_begun = False

    @property
    def cameras(self) -> dict[str, str]:
        """The cameras, by name."""
        return {name: name for name in self.config.camera_names}

    @property
    def observation_features(self) -> dict[str, Any]:
        """Positions and velocities by ``joint.pos`` and ``joint.vel``, and images.

        Raises:
            TransportError: If the bring-up does not run.
        """
        environment, robot = self._opened(), self._robot
        assert robot is not None
        sizes = {name: robot.camera(name).camera for name in self.cameras}
        return {
            **dict.fromkeys(named(environment.action_names, "pos"), float),
            **dict.fromkeys(named(environment.action_names, "vel"), float),
            **{name: (item.height, item.width, 3) for name, item in sizes.items()},
        }

    @property
    def action_features(self) -> dict[str, type]:
        """Target positions by ``joint.pos`` [rad | m]; errors as above."""
        return dict.fromkeys(named(self._opened().action_names, "pos"), float)

    @property
    def is_connected(self) -> bool:
        """Whether the arms are taken."""
        return self._has_begun

    @property
    def is_calibrated(self) -> bool:
        """Whether it is calibrated: always."""
        return True

    def connect(self, calibrate: bool = True) -> None:
        """Take the arms; nothing moves.

        Raises:
            TransportError: If the bring-up does not run.
            ControlError: If an arm is stopped, or taken by others.
        """
        self._opened().begin(0)
        self._has_begun = True

    def calibrate(self) -> None:
        """Do nothing: its encoders are absolute."""

    def configure(self) -> None:
        """Do nothing: the bring-up has all settings."""

    def get_observation(self) -> dict[str, Any]:
        """Return joints and images as they are now."""
        environment = self._connected()
        values = environment.see().values
        joints = environment.action_names
        return {
            **dict(zip(named(joints, "pos"), values["position"].tolist(), strict=True)),
            **dict(zip(named(joints, "vel"), values["velocity"].tolist(), strict=True)),
            **{name: values[name].copy() for name in self.cameras},  # to write to
        }

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Move towards target positions, and return those that were sent.

        Raises:
            ControlError: If the robot refuses, or a target is missing or not finite.
        """
        environment = self._connected()
        target = values_of(action, environment.action_names)
        sent = environment.nearest(np.array(target))
        environment.send(sent)
        names = named(environment.action_names, "pos")
        return dict(zip(names, sent.tolist(), strict=True))

    def disconnect(self) -> None:
        """Stop, give the arms back to their controllers, and end the connection."""
        if self._environment is not None and self._has_begun:
            self._environment.end()
        if self._robot is not None:
            self._robot.close()
        self._robot = self._environment = None
        self._has_begun = False

    def _opened(self) -> RobotEnvironment:
        if self._environment is None:
            self._robot = tool0.connect(self.config.bringup)
            self._environment = RobotEnvironment(
                self._robot, rate=self.config.fps, cameras=self.config.camera_names
            )
        return self._environment

    def _connected(self) -> RobotEnvironment:
        if not self._has_begun or self._environment is None:
            raise ControlError(f"{self} is not connected; call connect() first")
        return self._environment
