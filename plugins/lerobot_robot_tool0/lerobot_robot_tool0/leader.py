"""A bring-up of tool0 as a leader arm of LeRobot."""

from __future__ import annotations

from typing import Any, final

from lerobot_robot_tool0.config import Tool0LeaderConfig
from lerobot_robot_tool0.joints import named
from lerobot_robot_tool0.observer import Observer
from tool0.errors import ControlError


@final
class Tool0Leader(Observer):
    """Its joints are the actions: whoever moves it moves the other one."""

    config_class = Tool0LeaderConfig
    name = "tool0_leader"
    config: Tool0LeaderConfig

    @property
    def is_connected(self) -> bool:
        """Whether there is a connection to the bring-up."""
        return self._environment is not None

    def connect(self, calibrate: bool = True) -> None:
        """Connect to the bring-up; it is only observed.

        Raises:
            TransportError: If it does not run.
        """
        self._opened()

    def get_action(self) -> dict[str, Any]:
        """Return the positions of the joints now [rad | m]."""
        if self._environment is None:
            raise ControlError(f"{self} is not connected; call connect() first")
        position = self._environment.see().values["position"]
        names = named(self._environment.action_names, "pos")
        return dict(zip(names, position.tolist(), strict=True))
