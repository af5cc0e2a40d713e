"""A bring-up of tool0 as a leader arm of LeRobot."""

from __future__ import annotations

from typing import Any

from lerobot.teleoperators import Teleoperator

import tool0
from lerobot_robot_tool0.config import Tool0LeaderConfig
from lerobot_robot_tool0.joints import named
from tool0.errors import ControlError
from tool0.policy import RobotEnvironment


class Tool0Leader(Teleoperator):  # type: ignore[misc]  # LeRobot may not be installed
    """Its joints are the actions: whoever moves it moves the other one."""

    config_class = Tool0LeaderConfig
    name = "tool0_leader"

    def __init__(self, config: Tool0LeaderConfig) -> None:
        """Note which bring-up it is; it need not run yet."""
        super().__init__(config)
        self.config = config
        self._robot: tool0.Robot | None = None
        self._environment: RobotEnvironment | None = None

    @property
    def action_features(self) -> dict[str, type]:
        """Positions by ``joint.pos`` [rad | m].

        Raises:
            TransportError: If the bring-up does not run.
        """
        return dict.fromkeys(named(self._opened().action_names, "pos"), float)

    @property
    def feedback_features(self) -> dict[str, type]:
        """Nothing is fed back."""
        return {}

    @property
    def is_connected(self) -> bool:
        """Whether there is a connection to the bring-up."""
        return self._environment is not None

    @property
    def is_calibrated(self) -> bool:
        """Whether it is calibrated: always."""
        return True

    def connect(self, calibrate: bool = True) -> None:
        """Connect to the bring-up; it is only observed.

        Raises:
            TransportError: If it does not run.
        """
        self._opened()

    def calibrate(self) -> None:
        """Do nothing: its encoders are absolute."""

    def configure(self) -> None:
        """Do nothing: the bring-up has all settings."""

    def get_action(self) -> dict[str, Any]:
        """Return the positions of the joints now [rad | m]."""
        if self._environment is None:
            raise ControlError(f"{self} is not connected; call connect() first")
        position = self._environment.see().values["position"]
        names = named(self._environment.action_names, "pos")
        return dict(zip(names, position.tolist(), strict=True))

    def send_feedback(self, feedback: dict[str, Any]) -> None:
        """Do nothing."""

    def disconnect(self) -> None:
        """End the connection."""
        if self._robot is not None:
            self._robot.close()
        self._robot = self._environment = None

    def _opened(self) -> RobotEnvironment:
        if self._environment is None:
            self._robot = tool0.connect(self.config.bringup)
            self._environment = RobotEnvironment(self._robot)
        return self._environment
