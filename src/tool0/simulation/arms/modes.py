"""The modes of an arm, and the reasons why the arm may not move."""

from __future__ import annotations

from typing import NamedTuple, final

from tool0.protocol.control_box_state import (
    POWERED,
    UNSTOPPED,
    RobotMode,
    SafetyMode,
)


@final
class Modes(NamedTuple):
    """Modes of an arm, regardless of whether the emergency stop hides them."""

    robot: RobotMode = RobotMode.RUNNING
    safety: SafetyMode = SafetyMode.NORMAL

    @property
    def is_powered(self) -> bool:
        """Whether the arm is powered, with its brakes released."""
        return self.robot in POWERED

    @property
    def may_move(self) -> bool:
        """Whether the arm is powered, with released brakes and no active stop."""
        return self.is_powered and self.safety in UNSTOPPED

    def changed(self, robot: RobotMode | None, safety: SafetyMode | None) -> Modes:
        """Return a copy with other modes; None leaves a mode unchanged."""
        new = Modes(robot or self.robot, safety or self.safety)
        if new.robot is RobotMode.BACKDRIVE and new.safety not in UNSTOPPED:
            return new._replace(robot=RobotMode.RUNNING)
        return new

    def obstacle(self, arm: str, stopped_for: str) -> str:
        """Return the reason why the arm may not move, with a remedy.

        The text is empty if the arm may move.  ``stopped_for`` is the reason for the
        protective stop, if there is one.
        """
        handle = f"robot.arms['{arm}'].control_box"
        if self.safety is SafetyMode.PROTECTIVE_STOP:
            return (
                f"the arm '{arm}' is in a protective stop; unlock it in the panel or "
                f"with {handle}.unlock() (it stopped for: {stopped_for})"
            )
        if self.safety not in UNSTOPPED:
            return (
                f"the safety mode of the arm '{arm}' is {self.safety.name}; restart it "
                f"with {handle}.restart_safety()"
            )
        if not self.is_powered:
            is_off = self.robot is RobotMode.POWER_OFF
            return (
                f"the arm '{arm}' is {'powered off' if is_off else 'braked'}; power it "
                f"on and release its brakes with {handle}.release_brakes()"
            )
        return ""
