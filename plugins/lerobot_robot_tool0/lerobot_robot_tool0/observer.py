"""What teleoperators share that observe a bring-up of tool0."""

from __future__ import annotations

from typing import Any

from lerobot.teleoperators import Teleoperator

import tool0
from lerobot_robot_tool0.config import Tool0LeaderConfig, ToolTeleopConfig
from lerobot_robot_tool0.joints import named
from tool0.policy import RobotEnvironment


class Observer(Teleoperator):  # type: ignore[misc]  # LeRobot may not be installed
    """Actions are the positions of all driven joints: those of ``Tool0Robot``.

    It commands nothing in the bring-up.
    """

    def __init__(self, config: Tool0LeaderConfig | ToolTeleopConfig) -> None:
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
    def is_calibrated(self) -> bool:
        """Whether it is calibrated: always."""
        return True

    def calibrate(self) -> None:
        """Do nothing: positions and deflections are absolute."""

    def configure(self) -> None:
        """Do nothing: there are no settings in the device."""

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
