"""Pick and place: picks an object from above, and places it in a bin."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Protocol, final

from tool0.api.grasps import (
    CLEARANCE,
    Bin,
    find_grasps,
    finger_reach,
    half_height,
)
from tool0.cli.demos.hand import Hand, PickOptions, TaskFailure
from tool0.cli.demos.monitor import GraspMonitor
from tool0.cli.demos.report import PickReport
from tool0.errors import ControlError, ModelError
from tool0.protocol.state import Snapshot

if TYPE_CHECKING:
    from tool0.api.robot import Robot

DROP = 0.015
"""Height above the bin's floor at which the object is released [m]."""


@final
class Picker:
    """Performs one pick with one arm and its gripper."""

    def __init__(
        self,
        robot: Robot,
        item: str,
        options: PickOptions,
        monitor: GraspMonitor,
        name: str | None = None,
    ) -> None:
        """Find the grasps of the object at its present pose.

        Args:
            robot: The robot.
            item: An upright box, cylinder or sphere.
            options: Force and speeds of the pick.
            monitor: Advances simulated time, and measures the grip.
            name: Name of the arm and its gripper; required only if the
                robot has several arms.

        Raises:
            ControlError: If the object does not exist or cannot be gripped, or the
                gripper does not support the force or the speed.
        """
        self.hand = Hand(robot, options, monitor, name)
        geometry = self.hand.gripper.geometry
        self._monitor = monitor
        thing, pose = robot.scene[item], monitor.pose()
        self._grasps = find_grasps(thing, pose, geometry.max_opening)
        self._floor = pose.position[2] - half_height(thing, pose)
        reach = finger_reach(robot.description.model, geometry)
        top = 2.0 * pose.position[2] - self._floor
        # In a lower position, the fingers would touch the table, or the knuckles would
        # touch a tall object.
        self._height = max(
            pose.position[2], top - reach, self._floor + reach + CLEARANCE
        )
        """Height of the middle of the pads when they grip the object [m]."""
        self._grasp = self._grasps[0]
        self.width: float | None = None
        """Width of the gripped object, calculated from the position of the gripper's
        joint [m]."""
        self.force: float | None = None
        """Force of a pad on the object at the beginning of the lift [N]."""

    @property
    def width_between_pads(self) -> float:
        """Width of the object at the grasp, from the object's shape [m]."""
        return self._grasp.width

    def take(self) -> None:
        """Move to the object, grip it and lift it; a failed step raises TaskFailure."""
        hand, monitor, lift = self.hand, self._monitor, self.hand.options.lift
        x, y, _ = self._grasps[0].pose.position
        self._grasp = hand.nearest((x, y, self._height + lift), self._grasps)
        tool = hand.tool_for(self._grasp.width)
        above = self._grasp.pose
        down = replace(above, position=(x, y, self._height))

        monitor.begin("approaching")
        opening = hand.open()
        hand.move_to(above, tool)
        hand.finish(opening)
        monitor.begin("going down")
        hand.move_linear(down, tool)
        monitor.begin("gripping")
        hand.grip()
        self.width, self.force = hand.gripper.state.width, monitor.pad_force()
        monitor.start_slip(hand.gripper)
        monitor.begin("lifting")
        hand.move_linear(above, tool)
        hand.check_hold()

    def put(self, into: Bin) -> None:
        """Carry the object to a bin and release it; a failure raises TaskFailure."""
        self.hand.put(into, self._grasps, self._height - self._floor + DROP)


def pick_and_place(
    robot: Robot,
    item: str,
    into: Bin,
    options: PickOptions | None = None,
    on_snapshot: Callable[[Snapshot], None] = lambda snapshot: None,
) -> PickReport:
    """Pick an object from above, place it in a bin, and return the measurements.

    Only friction holds the object, unless the robot has grasp assist.

    Args:
        robot: A robot with one arm that has analytic inverse kinematics, and one
            gripper.
        item: The name of an upright, movable box, cylinder or sphere.
        into: Bin for the object.
        options: Force and speeds of the pick.
        on_snapshot: Called with each snapshot, for recording.

    Raises:
        ControlError: If the object does not exist, or if it cannot be gripped.
        EngineError: If the physics fails.
    """
    options = options or PickOptions()
    with contextlib.closing(GraspMonitor(robot, item, on_snapshot)) as monitor:
        picker = Picker(robot, item, options, monitor)
        return pick_into(robot, picker, monitor, into)


class Picking(Protocol):
    """Picks and places an object, and measures the grip."""

    hand: Hand
    width: float | None
    """Width of the gripped object, calculated from the position of the gripper's joint
    [m]."""
    force: float | None
    """Force of a pad on the object at the beginning of the lift [N]."""

    def take(self) -> None:
        """Grip the object and lift it; a failed step raises TaskFailure."""

    def put(self, into: Bin) -> None:
        """Carry the object to a bin and release it; a failure raises TaskFailure."""


def pick_into(
    robot: Robot, picker: Picking, monitor: GraspMonitor, into: Bin
) -> PickReport:
    """Pick an object, place it in a bin, and return a report."""

    def task() -> None:
        picker.take()
        picker.put(into)

    return measured(robot, picker, monitor, task)


def measured(
    robot: Robot, picker: Picking, monitor: GraspMonitor, task: Callable[[], None]
) -> PickReport:
    """Perform a task with an object, and return the measurements of ``monitor``.

    Args:
        robot: The robot.
        picker: Picks the object up during the task.
        monitor: Measures how the object is held.
        task: Performs the task; raises TaskFailure, ControlError or ModelError on
            failure.
    """
    start, begun, failure = monitor.pose().position, robot.time, None
    try:
        task()
    except (TaskFailure, ControlError, ModelError) as error:
        failure = f"while {monitor.phase}: {error}"
    monitor.begin("")
    return PickReport(
        success=failure is None,
        failure=failure,
        item=monitor.item,
        start=start,
        end=monitor.pose().position if monitor.item in robot.scene else None,
        force=picker.hand.options.force,
        grip_force=picker.force,
        peak_force=monitor.peak_force,
        width=picker.width,
        slip=monitor.slip,
        duration=robot.time - begun,
        phases=monitor.phases,
    )
