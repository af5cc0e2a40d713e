"""The control box of an arm: the state of the box, and requests to the box."""

import math

from tool0_ros2 import requests
from tool0_ros2.bridge import Context, ControllerContext, Update
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.requests import ControlBoxState

NORMAL_MODES = (1, 2)
"""Safety modes in which the arm may move: NORMAL and REDUCED."""
ROBOT_EMERGENCY_STOP = 7
"""Safety mode after an emergency stop at the robot."""
_POWERED_MODES = (6, 7)
"""Robot modes in which the brakes are released: BACKDRIVE and RUNNING."""


def is_program_running(state: ControlBoxState) -> bool:
    """Return whether ROS can move the arm.

    ROS can move the arm while the arm's program is playing and no stop is active.
    """
    return (
        state["program"] == "PLAYING"
        and not state["taken_by"]
        and state["robot_mode"] in _POWERED_MODES
        and state["safety_mode"] in NORMAL_MODES
    )


class ControlBox:
    """The control box of the arm whose names have the given prefix."""

    def __init__(self, context: Context, prefix: str) -> None:
        """Find the control box.  ``prefix`` is the prefix of the arm's full names.

        Raises:
            RequestFailedError: If no arm has this prefix.
        """
        self._context = context
        boxes = read_boxes(context)
        found = [box for box in boxes if box["prefix"] == prefix]
        if not found:
            known = ", ".join(
                f"'{context.names.to_ros(box['prefix'])}'" for box in boxes
            )
            raise RequestFailedError(
                "ControlError",
                f"no arm has the prefix '{context.names.to_ros(prefix)}'; "
                f"valid: {known}",
            )
        self.arm: str = found[0]["arm"]
        self.flange: str = f"{prefix}tool0"
        """The full name of ``tool0``, which is the arm's last link."""

    def state(self, update: Update) -> ControlBoxState:
        """Return the box's state, which is the same object until a value changes."""
        return next(box for box in update.control_boxes if box["arm"] == self.arm)

    def rated_payload(self) -> float:
        """Return the arm's rated payload [kg]; infinite if it is unknown."""
        arms = self._context.connection.call(requests.list_arms())
        found = next(arm["rated_payload"] for arm in arms if arm["name"] == self.arm)
        return math.inf if found is None else found

    def read(self) -> ControlBoxState:
        """Request the current state of the control box."""
        return self._context.connection.call(requests.read_io(arm=self.arm))


def read_boxes(context: Context) -> list[ControlBoxState]:
    """Return the control box of each arm in the namespace."""
    use = "the control boxes of arms"
    arms = context.ask(requests.list_arms(), use) or []
    boxes = (
        context.ask(requests.read_io(arm=arm["name"]), use)
        for arm in arms
        if context.names.owns(arm["tip"])
    )
    return [box for box in boxes if box is not None]


def flange_of(context: Context, name: str) -> str:
    """Return the full name of the link ``tool0`` of an arm.

    ``name`` is any full name with the arm's prefix.

    Raises:
        RequestFailedError: If no arm has the prefix of ``name``.
    """
    boxes = sorted(read_boxes(context), key=lambda box: -len(box["prefix"]))
    for box in boxes:
        if name.startswith(box["prefix"]) or len(boxes) == 1:
            return f"{box['prefix']}tool0"
    raise RequestFailedError(
        "ConfigError",
        f"'{context.names.to_ros(name)}' begins with no arm's prefix; valid: "
        + ", ".join(context.names.to_ros(box["prefix"]) for box in boxes),
    )


def is_running(context: ControllerContext) -> bool:
    """Return whether the controller of a part is currently active."""
    return any(
        status["is_running"]
        for status in context.connection.call(requests.list_controllers())
        if status["name"] == context.name
    )
