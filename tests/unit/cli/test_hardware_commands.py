"""The output of ``tool0 hardware`` for states of a real robot."""

from __future__ import annotations

from msgspec.structs import replace

from tool0.cli.hardware import why_stopped
from tool0.description.payload import Payload
from tool0.protocol.control_box_state import ControlBoxState, ProgramState, RobotLink

ENABLED = ControlBoxState(
    arm="arm",
    prefix="",
    payload=Payload(0.0, (0.0, 0.0, 0.0)),
    link=RobotLink(address="192.168.1.10", is_enabled=True),
)


def test_every_stop_of_an_enabled_robot_has_a_reason() -> None:
    assert not why_stopped(ENABLED)
    stopped = replace(ENABLED, program=ProgramState.STOPPED)
    assert why_stopped(stopped) == "a command stopped the arm"
    assert why_stopped(replace(stopped, protective_stop="a push")) == "a push"
    late = "the robot received nothing from tool0 for 0.1 s"
    assert why_stopped(replace(stopped, motion_failure=late)) == late


def test_a_robot_that_was_never_enabled_has_not_stopped() -> None:
    link = RobotLink(address="192.168.1.10")
    assert not why_stopped(replace(ENABLED, program=ProgramState.STOPPED, link=link))
